#include "core/command/condition.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"

namespace takt::command {
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

void read_threshold(ObjectReader& reader, Condition& condition) {
  const char* unit = is_torque(condition.quantity) ? "Nm" : "N";
  const std::string above = fmt::format("above_{}", unit);
  const std::string below = fmt::format("below_{}", unit);
  const bool both_or_none = (reader.child(above) != nullptr) == (reader.child(below) != nullptr);
  if (both_or_none) {
    reader.findings().error(reader.pointer(), "exactly one threshold is needed",
                            fmt::format("'{}' or '{}'", above, below));
  }
  condition.above = reader.has(above);
  condition.threshold = reader.number(condition.above ? above : below, 0.0);
}

Condition read_condition(const Json& json, const std::string& pointer, const Cell& cell, Findings& findings);

std::vector<Condition> read_operands(ObjectReader& reader, std::string_view key, const Cell& cell) {
  std::vector<Condition> operands;
  const Json* list = reader.array(key);
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    operands.push_back(read_condition((*list)[i], reader.at(key) + pointer_segment(i), cell, reader.findings()));
  }
  if (operands.empty()) reader.findings().error(reader.at(key), "no condition stands here", "at least one");
  return operands;
}

Condition read_comparison(ObjectReader& reader, const Cell& cell) {
  Condition condition;
  if (!reader.json().is_object()) return condition;
  condition.sensor = reader.text("sensor");
  if (reader.has("sensor") && !cell.sensors.contains(condition.sensor)) {
    std::vector<std::string> names;
    for (const auto& [name, sensor] : cell.sensors) names.push_back(name);
    reader.findings().error(reader.at("sensor"), fmt::format("there is no force/torque sensor '{}'", condition.sensor),
                            nearest_choice(condition.sensor, names));
  }
  const std::string quantity = reader.choice("quantity", quantity_names(), "force");
  const auto found =
      std::ranges::find(kQuantities, quantity, [](const auto& entry) { return std::string(entry.name); });
  if (found != kQuantities.end()) condition.quantity = found->quantity;
  read_threshold(reader, condition);
  return condition;
}

/// Recursion is bounded by the depth that JSON files may have.
Condition read_condition(const Json& json, const std::string& pointer, const Cell& cell, Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  Condition condition;
  if (reader.has("all")) {
    condition.kind = Condition::Kind::kAll;
    condition.operands = read_operands(reader, "all", cell);
  } else if (reader.has("any")) {
    condition.kind = Condition::Kind::kAny;
    condition.operands = read_operands(reader, "any", cell);
  } else if (reader.has("not")) {
    condition.kind = Condition::Kind::kNot;
    condition.operands.push_back(read_condition(*reader.child("not"), reader.at("not"), cell, findings));
  } else {
    condition = read_comparison(reader, cell);
  }
  reader.finish();
  return condition;
}

void collect(const Condition& condition, std::vector<std::string>& names) {
  if (condition.kind == Condition::Kind::kComparison && std::ranges::find(names, condition.sensor) == names.end()) {
    names.push_back(condition.sensor);
  }
  for (const Condition& operand : condition.operands) collect(operand, names);
}

}  // namespace

Result<Condition> parse_condition(const Json& json, const std::string& pointer, const Cell& cell) {
  Findings findings;
  Condition condition = read_condition(json, pointer, cell, findings);
  if (findings.has_errors()) return std::unexpected(std::move(findings));
  return condition;
}

std::vector<std::string> sensors_of(const Condition& condition) {
  std::vector<std::string> names;
  collect(condition, names);
  return names;
}

bool is_torque(Quantity quantity) { return quantity >= Quantity::kTorque; }

}  // namespace takt::command
