#include "core/expression/condition.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/collision/cell_shapes.h"

namespace takt::expression {
namespace {

using Json = nlohmann::ordered_json;

struct QuantityName {
  Quantity quantity;
  const char* name;
};

constexpr std::array<QuantityName, 8> kQuantities{{{Quantity::kForce, "force"},
                                                   {Quantity::kForceX, "force_x"},
                                                   {Quantity::kForceY, "force_y"},
                                                   {Quantity::kForceZ, "force_z"},
                                                   {Quantity::kTorque, "torque"},
                                                   {Quantity::kTorqueX, "torque_x"},
                                                   {Quantity::kTorqueY, "torque_y"},
                                                   {Quantity::kTorqueZ, "torque_z"}}};

std::vector<std::string> quantity_names() {
  std::vector<std::string> names;
  for (const auto& entry : kQuantities) names.emplace_back(entry.name);
  return names;
}

/// @param unit  in the names of the keys; empty: they have none
void read_threshold(ObjectReader& reader, const std::string& unit, Condition& condition) {
  const std::string above = unit.empty() ? "above" : fmt::format("above_{}", unit);
  const std::string below = unit.empty() ? "below" : fmt::format("below_{}", unit);
  const bool both_or_none = (reader.child(above) != nullptr) == (reader.child(below) != nullptr);
  if (both_or_none) {
    reader.diagnostics().error(Code::kConflict, reader.pointer(), "exactly one threshold is needed",
                               fmt::format("Give '{}' or '{}'", above, below));
  }
  condition.above = reader.has(above);
  condition.threshold = reader.number(condition.above ? above : below, 0.0);
}

template <class Map>
bool known_device(ObjectReader& reader, const char* key, const char* what, const Map& devices,
                  const std::string& name) {
  if (!reader.has(key) || devices.contains(name)) return true;
  std::vector<std::string> names;
  for (const auto& [device, mounted] : devices) names.push_back(device);
  reader.diagnostics().error(Code::kUnknownName, reader.at(key), fmt::format("there is no {} '{}'", what, name),
                             nearest_choice(name, names));
  return false;
}

Condition condition_of(const Json& json, const std::string& pointer, const Cell& cell, Diagnostics& diagnostics);

std::vector<Condition> read_operands(ObjectReader& reader, std::string_view key, const Cell& cell) {
  std::vector<Condition> operands;
  const Json* list = reader.array(key);
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    operands.push_back(condition_of((*list)[i], reader.at(key) + pointer_segment(i), cell, reader.diagnostics()));
  }
  if (operands.empty())
    reader.diagnostics().error(Code::kMissing, reader.at(key), "no condition is given", "Give at least one");
  return operands;
}

Condition read_comparison(ObjectReader& reader, const Cell& cell) {
  Condition condition;
  if (!reader.json().is_object()) return condition;
  condition.device = reader.text("sensor");
  known_device(reader, "sensor", "force/torque sensor", cell.sensors, condition.device);
  condition.quantity = read_quantity(reader);
  read_threshold(reader, is_torque(condition.quantity) ? "Nm" : "N", condition);
  return condition;
}

/// Of two sensors that are not on one arm.
Condition read_internal_force(ObjectReader& reader, const Cell& cell) {
  Condition condition;
  condition.kind = Condition::Kind::kInternalForce;
  const std::string place = reader.at("internal_force");
  const auto names = reader.texts("internal_force");
  read_threshold(reader, "N", condition);
  if (names.size() != 2) {
    reader.diagnostics().error(Code::kWrongSize, place, fmt::format("{} sensors", names.size()),
                               "Name two: one on each arm");
    return condition;
  }
  condition.device = names[0];
  condition.other = names[1];
  std::vector<std::string> sensors;
  for (const auto& [name, mounted] : cell.sensors) sensors.push_back(name);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (cell.sensors.contains(names[i])) continue;
    reader.diagnostics().error(Code::kUnknownName, place + pointer_segment(i),
                               fmt::format("there is no force/torque sensor '{}'", names[i]),
                               nearest_choice(names[i], sensors));
  }
  const auto one = cell.sensors.find(names[0]), two = cell.sensors.find(names[1]);
  const bool known = one != cell.sensors.end() && two != cell.sensors.end() && !one->second.arm.empty();
  if (known && one->second.arm == two->second.arm) {
    reader.diagnostics().error(Code::kConflict, place,
                               fmt::format("'{}' and '{}' are both on '{}'", names[0], names[1], one->second.arm),
                               "Name sensors on two arms");
  }
  return condition;
}

/// Of two bodies, an arm with what it carries.
Condition read_distance(ObjectReader& reader, const Cell& cell) {
  Condition condition;
  condition.kind = Condition::Kind::kDistance;
  const std::string place = reader.at("distance");
  const auto names = reader.texts("distance");
  read_threshold(reader, "m", condition);
  if (names.size() != 2) {
    reader.diagnostics().error(Code::kWrongSize, place, fmt::format("{} names", names.size()),
                               "Name two devices, objects or bodies");
    return condition;
  }
  condition.device = names[0];
  condition.other = names[1];
  if (cell.shapes == nullptr) return condition;  // only names are known
  const std::vector<std::string> known = cell.shapes->names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::ranges::find(known, names[i]) != known.end()) continue;
    reader.diagnostics().error(Code::kUnknownName, place + pointer_segment(i),
                               fmt::format("there is no device, object or body '{}'", names[i]),
                               nearest_choice(names[i], known));
  }
  return condition;
}

/// Thresholds of an input whose unit is unknown, as its model could not be read: only the form is checked.
void skip_thresholds(ObjectReader& reader) {
  for (const auto& [key, value] : reader.json().items()) {
    if (key.starts_with("above_") || key.starts_with("below_")) (void)reader.number(key);
  }
}

Condition read_input(ObjectReader& reader, const Cell& cell) {
  Condition condition;
  condition.device = reader.text("input");
  const auto analog = cell.analog_inputs.find(condition.device);
  if (analog != cell.analog_inputs.end()) {
    condition.kind = Condition::Kind::kAnalog;
    if (analog->second) {
      read_threshold(reader, analog->second->description().unit, condition);
    } else {
      skip_thresholds(reader);
    }
    return condition;
  }
  condition.kind = Condition::Kind::kDigital;
  std::map<std::string, bool, std::less<>> names;
  for (const auto& [name, device] : cell.digital_inputs) names[name];
  for (const auto& [name, device] : cell.analog_inputs) names[name];
  if (!known_device(reader, "input", "input", names, condition.device)) skip_thresholds(reader);
  condition.level = reader.boolean("is", true);
  return condition;
}

Condition read_gripper(ObjectReader& reader, const Cell& cell) {
  Condition condition;
  condition.kind = Condition::Kind::kGripper;
  condition.device = reader.text("gripper");
  known_device(reader, "gripper", "gripper", cell.grippers, condition.device);
  condition.state = reader.choice("is", {"holding", "lost", "moving", "open", "closed"});
  return condition;
}

/// Its keys say of which type it is to be; what a channel carries is in its declaration.
Condition read_channel(ObjectReader& reader, const Cell& cell) {
  Condition condition;
  condition.device = reader.text("channel");
  known_device(reader, "channel", "channel", cell.channels, condition.device);
  const bool compared = reader.has("above") || reader.has("below");
  condition.kind = compared ? Condition::Kind::kRealChannel : Condition::Kind::kBooleanChannel;
  if (compared) {
    read_threshold(reader, "", condition);
  } else {
    condition.level = reader.boolean("is", true);
  }
  const auto found = cell.channels.find(condition.device);
  if (found == cell.channels.end() || found->second == nullptr) return condition;
  const net::ValueType carries = found->second->description().type;
  if (carries != (compared ? net::ValueType::kReal : net::ValueType::kBoolean)) {
    reader.diagnostics().error(Code::kTypeMismatch, reader.at("channel"),
                               fmt::format("'{}' carries {}", condition.device, net::name_of(carries)),
                               "Use a Boolean channel with 'is', a Real one with 'above' or 'below'");
  }
  return condition;
}

/// Recursion is bounded by the depth that JSON files may have.
Condition condition_of(const Json& json, const std::string& pointer, const Cell& cell, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  Condition condition;
  if (reader.has("all")) {
    condition.kind = Condition::Kind::kAll;
    condition.operands = read_operands(reader, "all", cell);
  } else if (reader.has("any")) {
    condition.kind = Condition::Kind::kAny;
    condition.operands = read_operands(reader, "any", cell);
  } else if (reader.has("not")) {
    condition.kind = Condition::Kind::kNot;
    condition.operands.push_back(condition_of(*reader.child("not"), reader.at("not"), cell, diagnostics));
  } else if (reader.has("internal_force")) {
    condition = read_internal_force(reader, cell);
  } else if (reader.has("distance")) {
    condition = read_distance(reader, cell);
  } else if (reader.has("input")) {
    condition = read_input(reader, cell);
  } else if (reader.has("gripper")) {
    condition = read_gripper(reader, cell);
  } else if (reader.has("channel")) {
    condition = read_channel(reader, cell);
  } else {
    condition = read_comparison(reader, cell);
  }
  reader.finish();
  return condition;
}

void collect(const Condition& condition, std::vector<std::string>& names) {
  const auto add = [&names](const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  const bool internal = condition.kind == Condition::Kind::kInternalForce;
  if (internal || condition.kind == Condition::Kind::kForce) add(condition.device);
  if (internal) add(condition.other);
  for (const Condition& operand : condition.operands) collect(operand, names);
}

}  // namespace

Result<Condition> parse_condition(const Json& json, const std::string& pointer, const Cell& cell) {
  Diagnostics diagnostics;
  Condition condition = condition_of(json, pointer, cell, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return condition;
}

std::optional<Condition> read_condition(ObjectReader& reader, std::string_view key, const Cell& cell, bool required) {
  const Json* json = reader.object(key, required);
  if (json == nullptr) return std::nullopt;
  auto condition = parse_condition(*json, reader.at(key), cell);
  if (condition) return std::move(*condition);
  reader.diagnostics().append(condition.error());
  return std::nullopt;
}

std::vector<std::string> sensors_of(const Condition& condition) {
  std::vector<std::string> names;
  collect(condition, names);
  return names;
}

std::optional<net::FileUnit> unit_in_condition(std::string_view pointer) {
  const std::string_view key = pointer.substr(pointer.rfind('/') + 1);
  for (const std::string_view start : {"above_", "below_"}) {
    if (!key.starts_with(start)) continue;
    const auto terms = net::parse_unit(key.substr(start.size()));
    if (terms && terms->size() == 1 && terms->front().variables.empty()) return net::FileUnit{terms->front().dimension};
  }
  return std::nullopt;
}

bool is_torque(Quantity quantity) { return quantity >= Quantity::kTorque; }

Quantity read_quantity(ObjectReader& reader) {
  const std::string quantity = reader.choice("quantity", quantity_names(), "force");
  const auto found =
      std::ranges::find(kQuantities, quantity, [](const auto& entry) { return std::string(entry.name); });
  return found == kQuantities.end() ? Quantity::kForce : found->quantity;
}

}  // namespace takt::expression
