#include "core/operations/table/state_parameters.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/expression/condition_state.h"
#include "core/expression/device_sensors.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;
using StateKind = StateParameters::Kind;

constexpr std::array<const char*, 8> kOfCommands = {"started", "active",    "completed", "failed",
                                                    "stopped", "cancelled", "paused",    "timed_out"};

template <class Map>
void append_names(const Map& map, std::vector<std::string>& names) {
  for (const auto& [name, device] : map) names.push_back(name);
}

std::vector<std::string> actuators_of(const expression::Cell& cell) {
  std::vector<std::string> names;
  append_names(cell.arms, names);
  append_names(cell.grippers, names);
  append_names(cell.digital_outputs, names);
  append_names(cell.analog_outputs, names);
  return names;
}

void read_action(ObjectReader& reader, StateParameters& state) {
  state.kind = StateKind::kAction;
  state.of = reader.text("action");
  if (reader.has("at_path")) {
    state.is = "at_path";
    state.share = reader.number("at_path", {}, {.low = 0.0, .high = 1.0});
  } else if (reader.has("via_passed")) {
    state.is = "via_passed";
    state.index = static_cast<int>(reader.integer("via_passed", {}, {.low = 0, .high = 1000}));
  } else {
    state.is = reader.text("is");
  }
}

/// Recursion is bounded by the depth that JSON files may have.
std::vector<StateParameters> read_operands(ObjectReader& reader, const char* key, const expression::Cell& cell) {
  std::vector<StateParameters> operands;
  const Json* list = reader.array(key);
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    operands.push_back(read_state((*list)[i], reader.at(key) + pointer_segment(i), cell, reader.diagnostics()));
  }
  if (operands.empty())
    reader.diagnostics().error(Code::kMissing, reader.at(key), "no state is given", "Give at least one");
  return operands;
}

/// What conditions do not know. @return false: it is a condition.
bool read_own_form(ObjectReader& reader, const expression::Cell& cell, StateParameters& state) {
  if (reader.has("all") || reader.has("any")) {
    const bool all = reader.has("all");
    state.kind = all ? StateKind::kAll : StateKind::kAny;
    state.operands = read_operands(reader, all ? "all" : "any", cell);
    return true;
  }
  if (const Json* denied = reader.has("not") ? reader.child("not") : nullptr) {
    state.kind = StateKind::kNot;
    state.operands.push_back(read_state(*denied, reader.at("not"), cell, reader.diagnostics()));
    return true;
  }
  for (const char* word : kOfCommands) {
    if (!reader.has(word)) continue;
    state.kind = StateKind::kCommand;
    state.of = reader.text(word);
    state.is = word;
    return true;
  }
  if (reader.has("action")) {
    read_action(reader, state);
  } else if (reader.has("actuator")) {
    state.kind = StateKind::kActuator;
    state.of = reader.choice("actuator", actuators_of(cell));
    state.is = reader.choice("is", {"completed", "invalid_set_point", "emergency_stop"});
  } else if (reader.has("raised")) {
    state.kind = StateKind::kRaised;
    state.of = reader.text("raised");
  } else {
    return false;
  }
  return true;
}

bool is_known_form(const Json& json) {
  static constexpr std::array<const char*, 5> kConditions = {"sensor", "input", "gripper", "channel", "internal_force"};
  return std::ranges::any_of(kConditions, [&](const char* key) { return json.contains(key); });
}

}  // namespace

StateParameters read_state(const Json& json, const std::string& pointer, const expression::Cell& cell,
                           Diagnostics& diagnostics) {
  StateParameters state;
  state.pointer = pointer;
  ObjectReader reader(json, pointer, diagnostics);
  if (!json.is_object()) return state;
  if (reader.has("held_for_s")) state.held_for = reader.number("held_for_s", {}, {.low = 0.0, .high = 3600.0});
  if (read_own_form(reader, cell, state)) {
    reader.finish();
    return state;
  }
  if (!is_known_form(json)) {
    diagnostics.error(Code::kMissing, pointer, "no state is given",
                      "Give a condition over sensors, started, active, completed, failed, stopped, cancelled, paused, "
                      "timed_out of a command, action, actuator, raised, all, any or not");
    return state;
  }
  Json alone = json;
  alone.erase("held_for_s");
  auto condition = expression::parse_condition(alone, pointer, cell);
  if (condition) {
    state.condition = std::move(*condition);
  } else {
    diagnostics.append(condition.error());
  }
  return state;
}

ValueParameters read_value(const Json& json, const std::string& pointer, const expression::Cell& cell,
                           Diagnostics& diagnostics) {
  ValueParameters value;
  ObjectReader reader(json, pointer, diagnostics);
  if (!json.is_object()) return value;
  std::vector<std::string> names;
  const auto of = [&](const char* key, ValueParameters::Kind kind) {
    value.kind = kind;
    value.of = reader.choice(key, names);
  };
  if (reader.has("input")) {
    append_names(cell.digital_inputs, names);
    append_names(cell.analog_inputs, names);
    of("input", ValueParameters::Kind::kInput);
  } else if (reader.has("gripper")) {
    append_names(cell.grippers, names);
    of("gripper", ValueParameters::Kind::kWidth);
  } else if (reader.has("channel")) {
    append_names(cell.channels, names);
    of("channel", ValueParameters::Kind::kChannel);
  } else if (reader.has("speed")) {
    append_names(cell.arms, names);
    of("speed", ValueParameters::Kind::kSpeed);
  } else if (reader.has("progress")) {
    value.kind = ValueParameters::Kind::kProgress;
    value.of = reader.text("progress");
  } else {
    append_names(cell.sensors, names);
    of("sensor", ValueParameters::Kind::kForce);
    value.quantity = expression::read_quantity(reader);
  }
  reader.finish();
  return value;
}

bool is_boolean(const ValueParameters& value, const expression::Cell& cell) {
  if (value.kind == ValueParameters::Kind::kInput) return cell.digital_inputs.contains(value.of);
  if (value.kind != ValueParameters::Kind::kChannel) return false;
  const auto found = cell.channels.find(value.of);  // null where only names are known yet
  return found != cell.channels.end() && found->second != nullptr &&
         found->second->description().type == net::ValueType::kBoolean;
}

bool check_number(const ValueParameters& value, const expression::Cell& cell, const std::string& pointer,
                  Diagnostics& diagnostics) {
  const auto refuse = [&](const char* key, std::string_view is, const char* way_out) {
    diagnostics.error(Code::kInvalidValue, pointer + key, fmt::format("'{}' is {}", value.of, is), way_out);
    return false;
  };
  if (value.kind == ValueParameters::Kind::kInput && is_boolean(value, cell))
    return refuse("/input", "true or false", "an analog input");
  if (value.kind != ValueParameters::Kind::kChannel) return true;
  const auto found = cell.channels.find(value.of);
  if (found == cell.channels.end() || found->second == nullptr) return true;  // reported elsewhere, or later
  const net::ValueType type = found->second->description().type;
  return type == net::ValueType::kReal ||
         refuse("/channel", fmt::format("a channel of {}", net::name_of(type)), "a channel of Real");
}

std::optional<std::string> unit_of(const ValueParameters& value, const expression::Cell& cell) {
  switch (value.kind) {
    case ValueParameters::Kind::kForce:
      return expression::is_torque(value.quantity) ? "Nm" : "N";
    case ValueParameters::Kind::kWidth:
      return "m";
    case ValueParameters::Kind::kSpeed:
      return "m/s";
    case ValueParameters::Kind::kProgress:
      return "1";
    case ValueParameters::Kind::kInput: {
      const auto input = cell.analog_inputs.find(value.of);
      return input == cell.analog_inputs.end() ? std::nullopt : std::optional(input->second->description().unit);
    }
    default: {
      const auto channel = cell.channels.find(value.of);
      const bool known = channel != cell.channels.end() && channel->second != nullptr;
      return known ? std::optional(channel->second->description().unit) : std::nullopt;
    }
  }
}

expression::RealSensor number_of(const ValueParameters& value, const expression::Cell& cell,
                                 const expression::Biases& biases) {
  switch (value.kind) {
    case ValueParameters::Kind::kForce:
      return expression::contact_quantity(cell, value.of, value.quantity, biases);
    case ValueParameters::Kind::kWidth:
      return expression::gripper_width(cell, value.of);
    case ValueParameters::Kind::kSpeed:
      return norm(linear(expression::tool_twist(cell, value.of)));
    case ValueParameters::Kind::kInput:
      return expression::analog_input(cell, value.of);
    default:
      return expression::channel<net::Real>(cell, value.of);
  }
}

expression::State boolean_of(const ValueParameters& value, const expression::Cell& cell) {
  if (value.kind == ValueParameters::Kind::kInput) return expression::digital_input(cell, value.of);
  return expression::State(expression::channel<net::Boolean>(cell, value.of).node());
}

}  // namespace takt::operations
