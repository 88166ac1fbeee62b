#include "core/expression/believed_shapes.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/expression/device_sensors.h"
#include "core/net/value_json.h"

namespace takt::expression {
namespace {

using collision::CellShapes;
using collision::CellState;
using Json = nlohmann::ordered_json;

/// The body of a flange or link.
int body_of(const CellShapes& shapes, const world::Carrier& carrier) {
  if (carrier.link.empty()) return shapes.arms.find(carrier.arm)->second.flange;
  return shapes.scene.find(carrier.arm + "/" + carrier.link);
}

/// What is held or rides is on a flange or link, all else stands in the world.
void put_objects(const Cell& cell, CellState& situation) {
  const CellShapes& shapes = *cell.shapes;
  for (const auto& [name, object] : cell.objects) {
    const int body = shapes.scene.root_of(name);
    if (body < 0) continue;
    for (std::string& gripper : cell.holders_of(name)) situation.holders[body].insert(std::move(gripper));
    collision::Fixing& fixing = situation.state.fixings[static_cast<std::size_t>(body)];
    const auto carrier = cell.knows(name) ? cell.carrier_of(name) : std::nullopt;
    const auto X_WO = carrier ? Result<Eigen::Isometry3d>(carrier->X_FO) : cell.frames.pose(name);
    if (X_WO) {
      fixing = {carrier ? body_of(shapes, *carrier) : -1, *X_WO};
    } else {
      situation.unknown.insert(body);
    }
  }
}

/// Names of devices and objects for the primitive: an arm's with all that it carries.
std::vector<std::string> owners_of(const CellShapes& shapes, const collision::ContactRules& rules,
                                   const std::vector<std::string>& side) {
  std::vector<std::string> names;
  const auto add = [&names](const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  for (const std::string& name : side) {
    add(name);
    if (!shapes.arms.contains(name)) continue;
    for (int body = 0; body < static_cast<int>(shapes.scene.bodies().size()); ++body)
      if (rules.arm_of(body) == name && !shapes.scene.body(body).parts.empty()) add(shapes.scene.body(body).owner);
  }
  return names;
}

/// The arms that move one of these.
void add_movers(const CellShapes& shapes, const collision::State& state, const std::vector<std::string>& names,
                std::set<std::string>& arms) {
  for (int body = 0; body < static_cast<int>(shapes.scene.bodies().size()); ++body) {
    const collision::Body& one = shapes.scene.body(body);
    const auto named = [&one](const std::string& name) { return name == one.owner || name == one.name; };
    if (std::ranges::none_of(names, named)) continue;
    for (int at = body; at >= 0;) {
      const collision::Body& below = shapes.scene.body(at);
      if (shapes.arms.contains(below.owner)) arms.insert(below.owner);
      at = below.root ? state.fixings[static_cast<std::size_t>(at)].parent : below.parent;
    }
  }
}

/// Where what no input of the primitive moves is.
Json placed(const Cell& cell, const CellState& situation, const FingerWidths& widths) {
  const CellShapes& shapes = *cell.shapes;
  Json objects = Json::object(), fingers = Json::object();
  for (const auto& [name, object] : cell.objects) {
    const int body = shapes.scene.root_of(name);
    if (body < 0 || situation.unknown.contains(body)) continue;
    const collision::Fixing& fixing = situation.state.fixings[static_cast<std::size_t>(body)];
    objects[name] = {{"on", fixing.parent < 0 ? std::string() : shapes.scene.body(fixing.parent).name},
                     {"pose", net::value_to_json(net::Frame(fixing.X_P))}};
  }
  for (const auto& [gripper, width] : widths) fingers[gripper] = width;
  return {{"objects", std::move(objects)}, {"fingers", std::move(fingers)}};
}

}  // namespace

void set_joints(const CellShapes& shapes, const std::string& arm, const kinematics::JointVector& q,
                collision::State& state) {
  const auto mechanism = shapes.arms.find(arm);
  if (mechanism == shapes.arms.end()) return;
  const auto& joints = mechanism->second.joints;
  for (std::size_t j = 0; j < joints.size() && static_cast<Eigen::Index>(j) < q.size(); ++j)
    state.q[static_cast<std::size_t>(joints[j])] = q[static_cast<Eigen::Index>(j)];
}

CellState believed_situation(const Cell& cell, const Places& q, const FingerWidths& widths) {
  const CellShapes& shapes = *cell.shapes;
  CellState situation{.state = shapes.scene.start()};
  for (const auto& [arm, joints] : q) set_joints(shapes, arm, joints, situation.state);
  for (const auto& [gripper, width] : widths) {
    const auto fingers = shapes.grippers.find(gripper);
    if (fingers == shapes.grippers.end()) continue;
    for (const int joint : fingers->second) situation.state.q[static_cast<std::size_t>(joint)] = 0.5 * width;
  }
  put_objects(cell, situation);
  return situation;
}

FingerWidths measured_widths(const Cell& cell) {
  FingerWidths widths;
  for (const auto& [name, gripper] : cell.grippers)
    if (gripper.device != nullptr && gripper.device->has_sample()) widths[name] = gripper.device->sample().width;
  return widths;
}

RealSensor smallest_distance(const Cell& cell, const std::vector<std::string>& side_a,
                             const std::vector<std::string>& side_b) {
  const auto refused = [](Code code, std::string message, std::string hint) {
    return RealSensor(broken(code, net::ValueType::kReal, std::move(message), std::move(hint)));
  };
  if (cell.shapes == nullptr) return refused(Code::kRequires, "this cell has no shapes", "a cell of a scenario file");
  const CellShapes& shapes = *cell.shapes;
  const std::vector<std::string> known = shapes.names();
  for (const auto* side : {&side_a, &side_b})
    for (const std::string& name : *side)
      if (std::ranges::find(known, name) == known.end())
        return refused(Code::kUnknownName, fmt::format("there is no device, object or body '{}'", name),
                       nearest_choice(name, known));
  const FingerWidths widths = measured_widths(cell);
  const CellState situation = believed_situation(cell, {}, widths);
  const collision::ContactRules rules(shapes, situation);
  const auto a = owners_of(shapes, rules, side_a), b = owners_of(shapes, rules, side_b);
  std::set<std::string> arms;
  add_movers(shapes, situation.state, a, arms);
  add_movers(shapes, situation.state, b, arms);
  if (arms.empty()) return refused(Code::kInvalidValue, "no arm moves one of these", "a body that an arm moves");
  Json pairs = Json::array();
  for (const std::string& one : a)
    for (const std::string& other : b)
      if (one != other) pairs.push_back({one, other});
  std::vector<std::pair<std::string, Operand>> joints;
  for (const std::string& arm : arms)
    joints.emplace_back(fmt::format("q_{}", joints.size() + 1), Operand{.node = measured_joints(cell, arm).node()});
  static const std::string kSolids = "cell/solids";
  auto node = std::make_shared<Expression>(*apply(
      net::ValueType::kReal, "SmallestDistance", joints,
      {{"solids", kSolids}, {"arms", arms}, {"pairs", std::move(pairs)}, {"placed", placed(cell, situation, widths)}},
      "distance"));
  node->primitive.id = "distance";
  node->resource = cell.solids;
  node->resource_name = kSolids;
  return RealSensor(node);
}

}  // namespace takt::expression
