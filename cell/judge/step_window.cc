#include "cell/judge/step_window.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::cell {
namespace {

constexpr std::string_view kBetween = " / ";

/// Without the round of a loop: "for_each (2)" is "for_each".
std::string_view name_of_part(std::string_view part) {
  const std::size_t round = part.rfind(" (");
  const bool has_round =
      round != part.npos && part.ends_with(')') && part.find_first_not_of("0123456789", round + 2) == part.size() - 1;
  return has_round ? part.substr(0, round) : part;
}

/// Takes the first part off.
std::string_view take_part(std::string_view& path) {
  const std::size_t end = std::min(path.find(kBetween), path.size());
  const std::string_view part = path.substr(0, end);
  path.remove_prefix(std::min(end + kBetween.size(), path.size()));
  return part;
}

}  // namespace

std::string_view node_in(std::string_view path, std::string_view name) {
  std::string_view rest = path, wanted = take_part(name);
  while (!rest.empty()) {
    const std::string_view part = take_part(rest);
    const std::string_view plain = name_of_part(part);
    if (part != wanted && plain != wanted) continue;
    if (name.empty()) {
      const auto end = static_cast<std::size_t>(part.data() - path.data()) + wanted.size();
      return path.substr(0, end);
    }
    wanted = take_part(name);
  }
  return {};
}

bool goes_through(std::string_view path, std::string_view name) { return !node_in(path, name).empty(); }

bool ends_with(std::string_view path, std::string_view name) {
  const auto last = [](std::string_view whole) {
    const std::size_t before = whole.rfind(kBetween);
    return before == whole.npos ? whole : whole.substr(before + kBetween.size());
  };
  const std::string_view part = last(path), wanted = last(name);
  return (part == wanted || name_of_part(part) == wanted) && goes_through(path, name);
}

std::vector<std::string_view> unknown_parts(std::string_view name, std::span<const std::string> steps) {
  const auto known = [&](std::string_view one) { return std::ranges::find(steps, one) != steps.end(); };
  std::vector<std::string_view> unknown;
  while (!name.empty()) {
    const std::string_view part = take_part(name);
    if (!known(part) && !known(name_of_part(part))) unknown.push_back(part);
  }
  return unknown;
}

void StepWindow::look(std::span<const std::string> paths) {
  inside_ = name_.empty() ||
            std::ranges::any_of(paths, [this](const std::string& path) { return goes_through(path, name_); });
  ran_ = ran_ || inside_;
}

void StepClock::hear(const LogEntry& entry) {
  if (node_.empty() || entry.source != "program" || entry.name != "begin") return;
  const std::string_view found = node_in(entry.step, node_);
  const bool itself = found.size() == std::string_view(entry.step).size();
  if (found.empty() || (!itself && found == running_)) return;
  running_ = found;
  begin_ = entry.time;
}

std::vector<Key> span_keys(const std::string& what) {
  return {number_key("from_s", "", TimeSpan::kAllowed,
                     what + " before this time do not count, s: simulated time, or with 'during' time since the step "
                            "began, each time that it does.")
              .by_default(0.0),
          number_key("to_s", "", TimeSpan::kAllowed,
                     what + " after this time do not count, s; as 'from_s', and not before it.")
              .optional("the end")};
}

TimeSpan read_span(FormReader& reader) {
  const TimeSpan whole;
  const TimeSpan span{reader.number("from_s"), reader.number("to_s", whole.to)};
  if (span.from > span.to)
    reader.diagnostics().error(Code::kConflict, reader.at("from_s"),
                               fmt::format("the window begins at {:g} s, after its end at {:g} s", span.from, span.to),
                               "Set from_s to at most to_s");
  return span;
}

Key during_key() {
  return text_key("during",
                  "While this step or any other node of the program runs, each time that it does; NAME (2) is its "
                  "second round, OUTER / INNER a node in another one.",
                  1)
      .optional("in the whole run");
}

std::string read_during(FormReader& reader, const StepNames& steps) {
  std::string name = reader.text("during");
  if (reader.has("during") && name.empty())
    reader.diagnostics().error(Code::kMissing, reader.at("during"), "an empty name", "Give the name of a step");
  if (!steps) return name;
  for (const std::string_view part : unknown_parts(name, *steps))
    reader.diagnostics().error(Code::kUnknownName, reader.at("during"), fmt::format("there is no step '{}'", part),
                               nearest_choice(std::string(part), *steps));
  return name;
}

}  // namespace takt::cell
