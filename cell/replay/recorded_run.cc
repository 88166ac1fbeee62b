#include "cell/replay/recorded_run.h"

#include <charconv>

#include <fmt/format.h>

#include "core/base/object_reader.h"

namespace takt::cell {
namespace {

std::optional<std::uint64_t> parse_seed(const std::string& text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(seed) : std::nullopt;
}

/// What the recorder noted of the run under this key.
std::optional<std::string> run_metadata(const record::Recording& recording, const std::string& key) {
  const auto run = recording.metadata().find("takt.run");
  if (run == recording.metadata().end()) return std::nullopt;
  const auto text = run->second.find(key);
  return text == run->second.end() ? std::nullopt : std::optional(text->second);
}

}  // namespace

Result<Description> recorded_scenario(const record::Recording& recording, const std::vector<Override>& overrides,
                                      std::optional<std::uint64_t> other_seed) {
  const auto scenario = recording.attachment("scenario.json");
  if (!scenario)
    return failure(Code::kMissing, {}, "there is no scenario in this recording", "Use one made by takt run --record");
  auto description = parse_description(*scenario, overrides, other_seed);
  if (!description || other_seed) return description;
  const auto text = run_metadata(recording, "seed");
  if (!text) return description;
  const auto seed = parse_seed(*text);
  if (!seed) {
    return failure(Code::kOutOfRange, {}, fmt::format("the recorded seed {} is not a number", short_dump(*text)),
                   "Give a whole number from 0 to 18446744073709551615");
  }
  description->seed = *seed;
  return description;
}

std::string recorded_entry(const record::Recording& recording) {
  return run_metadata(recording, "from").value_or(std::string());
}

}  // namespace takt::cell
