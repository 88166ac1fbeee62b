#include "scenario/recorded_run.h"

#include <charconv>

#include <fmt/format.h>

#include "core/base/object_reader.h"

namespace takt::scenario {
namespace {

std::optional<std::uint64_t> parse_seed(const std::string& text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(seed) : std::nullopt;
}

}  // namespace

Result<Description> recorded_scenario(const record::Recording& recording, const std::vector<Override>& overrides,
                                      std::optional<std::uint64_t> other_seed) {
  const auto scenario = recording.attachment("scenario.json");
  if (!scenario)
    return failure(Code::kMissing, {}, "there is no scenario in this recording", "one made by takt run --record");
  auto description = parse_description(*scenario, overrides, other_seed);
  if (!description || other_seed) return description;
  const auto run = recording.metadata().find("takt.run");
  if (run == recording.metadata().end()) return description;
  const auto text = run->second.find("seed");
  if (text == run->second.end()) return description;
  const auto seed = parse_seed(text->second);
  if (!seed) {
    return failure(Code::kOutOfRange, {}, fmt::format("the recorded seed {} is not a number", short_dump(text->second)),
                   "a whole number from 0 to 18446744073709551615");
  }
  description->seed = *seed;
  return description;
}

}  // namespace takt::scenario
