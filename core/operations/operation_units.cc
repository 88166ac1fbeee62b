// Units of numbers anywhere in an operation, commands of transactions and their handlers included.
#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/expression/condition.h"
#include "core/operations/step.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

std::string_view first_segment(std::string_view pointer) {
  pointer.remove_prefix(1);
  return pointer.substr(0, pointer.find('/'));
}

/// The element of an object or array at one segment of a pointer; null if there is none.
const Json* element(const Json& json, std::string_view segment) {
  const Json::json_pointer pointer("/" + std::string(segment));
  return json.contains(pointer) ? &json.at(pointer) : nullptr;
}

/// Times of handlers and states; all other numbers there are thresholds of conditions.
std::optional<FileUnit> unit_in_handler(std::string_view pointer) {
  const std::string_view key = pointer.substr(pointer.rfind('/') + 1);
  if (key == "after_s" || key == "held_for_s") return file_unit("s");
  return command::unit_in_condition(pointer);
}

}  // namespace

std::optional<FileUnit> unit_in_operation(const Json& json, std::string_view pointer) {
  if (!pointer.starts_with('/') || !json.is_object()) return std::nullopt;
  const std::string_view segment = first_segment(pointer);
  const std::string_view rest = pointer.substr(1 + segment.size());
  if ((segment == "commands" || segment == "steps") && !rest.empty()) {
    const std::string_view name = first_segment(rest);
    const Json* list = element(json, segment);
    const Json* part = list != nullptr ? element(*list, name) : nullptr;
    return part != nullptr ? unit_in_operation(*part, rest.substr(1 + name.size())) : std::nullopt;
  }
  if (segment == "on" || segment == "capture") return unit_in_handler(pointer);
  // An object at "value" says what an output follows; it holds no numbers with units.
  const Json word = json.value("do", Json());
  const auto kind = std::ranges::find_if(step_kinds(), [&](const StepKind& one) { return word == one.name; });
  return kind != step_kinds().end() ? unit_at(kind->parameters(), pointer) : std::nullopt;
}

}  // namespace takt::activity
