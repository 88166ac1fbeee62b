#include "core/operations/table/operation.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/expression/condition.h"

namespace takt::operations {

/// All operations of takt: NAME is defined by NAME_operation() in a file of its own (core/operations/README.md).
// clang-format off
#define TAKT_OPERATIONS(add) \
  add(attach) \
  add(circ) \
  add(control_mode) \
  add(couple) \
  add(detach) \
  add(fit_pose) \
  add(follow) \
  add(freedrive) \
  add(grip) \
  add(hold) \
  add(jog) \
  add(lin) \
  add(look_at) \
  add(motions) \
  add(move) \
  add(net) \
  add(press) \
  add(ptp) \
  add(record_contact) \
  add(release) \
  add(search) \
  add(set) \
  add(set_frame) \
  add(spline) \
  add(tare) \
  add(transaction) \
  add(uncouple) \
  add(wait) \
  add(weld) \
  add(wipe)
// clang-format on

#define TAKT_DECLARE_OPERATION(name) Operation name##_operation();
TAKT_OPERATIONS(TAKT_DECLARE_OPERATION)

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
std::optional<net::FileUnit> unit_in_handler(std::string_view pointer) {
  const std::string_view key = pointer.substr(pointer.rfind('/') + 1);
  if (key == "after_s" || key == "held_for_s") return net::file_unit("s");
  if (key == "rate_Hz") return net::file_unit("Hz");
  return expression::unit_in_condition(pointer);
}

std::vector<std::string> names_of(const std::vector<Operation>& operations, const auto& has) {
  std::vector<std::string> names;
  for (const Operation& one : operations)
    if (has(one)) names.emplace_back(one.name);
  return names;
}

}  // namespace

// -- The registry ----------------------------------------------------------------------------------------------------

Operations& Operations::global() {
  static Operations operations;
  return operations;
}

Operations::Operations() {
#define TAKT_ADD_OPERATION(name) add(name##_operation());
  TAKT_OPERATIONS(TAKT_ADD_OPERATION)
}

void Operations::add(const Operation& operation) {
  const auto place = std::ranges::lower_bound(operations_, operation.name, {}, &Operation::name);
  if (place != operations_.end() && place->name == operation.name) {
    std::fprintf(stderr, "takt: operation %s is registered twice\n", std::string(operation.name).c_str());
    std::abort();
  }
  operations_.insert(place, operation);
}

const Operation* Operations::find(std::string_view name) const {
  const auto found = std::ranges::lower_bound(operations_, name, {}, &Operation::name);
  return found != operations_.end() && found->name == name ? &*found : nullptr;
}

std::vector<std::string> Operations::step_types() const {
  return names_of(operations_, [](const Operation& one) { return one.read_step != nullptr; });
}

std::vector<std::string> Operations::command_types() const {
  return names_of(operations_, [](const Operation& one) { return one.read_command != nullptr; });
}

Diagnostics OperationRegistration::check() const {
  Diagnostics diagnostics;
  if (operation_.name.empty()) diagnostics.error(Code::kMissing, "", "an operation has no name");
  if (Operations::global().find(operation_.name) != nullptr) {
    diagnostics.error(Code::kDuplicate, "", fmt::format("an operation '{}' already exists", operation_.name),
                      "Choose another name");
  }
  if (operation_.parameters == nullptr || (operation_.read_step == nullptr && operation_.read_command == nullptr)) {
    diagnostics.error(Code::kMissing, "", fmt::format("operation '{}' is incomplete", operation_.name),
                      "Give it parameters, and say how it is read as a step, as a command, or both");
  }
  return diagnostics;
}

// -- Units -----------------------------------------------------------------------------------------------------------

std::optional<net::FileUnit> unit_in_operation(const Json& json, std::string_view pointer) {
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
  const Operation* operation = word.is_string() ? Operations::global().find(word.get<std::string>()) : nullptr;
  return operation != nullptr ? unit_at(operation->parameters(), pointer) : std::nullopt;
}

}  // namespace takt::operations
