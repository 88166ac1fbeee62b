#include "scenario/step_window.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::scenario {
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

bool goes_through(std::string_view path, std::string_view name) {
  std::string_view wanted = take_part(name);
  while (!path.empty()) {
    const std::string_view part = take_part(path);
    if (part != wanted && name_of_part(part) != wanted) continue;
    if (name.empty()) return true;
    wanted = take_part(name);
  }
  return false;
}

bool ends_with(std::string_view path, std::string_view name) {
  const auto last = [](std::string_view whole) {
    const std::size_t before = whole.rfind(kBetween);
    return before == whole.npos ? whole : whole.substr(before + kBetween.size());
  };
  const std::string_view part = last(path), wanted = last(name);
  return (part == wanted || name_of_part(part) == wanted) && goes_through(path, name);
}

std::string_view unknown_part(std::string_view name, std::span<const std::string> steps) {
  const auto known = [&](std::string_view one) { return std::ranges::find(steps, one) != steps.end(); };
  while (!name.empty()) {
    const std::string_view part = take_part(name);
    if (!known(part) && !known(name_of_part(part))) return part;
  }
  return {};
}

void StepWindow::look(std::span<const std::string> paths) {
  inside_ = name_.empty() ||
            std::ranges::any_of(paths, [this](const std::string& path) { return goes_through(path, name_); });
}

std::string read_during(ObjectReader& reader, const StepNames& steps) {
  std::string name = reader.text("during", "");
  if (reader.has("during") && name.empty())
    reader.diagnostics().error(Code::kMissing, reader.at("during"), "an empty name", "the name of a step");
  if (!steps) return name;
  if (const std::string_view part = unknown_part(name, *steps); !part.empty())
    reader.diagnostics().error(Code::kUnknownName, reader.at("during"), fmt::format("there is no step '{}'", part),
                               nearest_choice(std::string(part), *steps));
  return name;
}

}  // namespace takt::scenario
