#include "core/expression/condition_state.h"

#include "core/expression/believed_shapes.h"
#include "core/expression/device_sensors.h"

namespace takt::expression {
namespace {

State compared(const RealSensor& sensor, const Condition& condition) {
  return condition.above ? is_greater(sensor, condition.threshold) : is_less(sensor, condition.threshold);
}

/// Recursion is bounded by the depth of the file that the condition came from.
State combined(const Condition& condition, const Cell& cell, const Biases& biases) {
  State result = state_of(condition.operands.front(), cell, biases);
  for (std::size_t i = 1; i < condition.operands.size(); ++i) {
    const State operand = state_of(condition.operands[i], cell, biases);
    result = condition.kind == Condition::Kind::kAll ? (result && operand) : (result || operand);
  }
  return result;
}

}  // namespace

RealSensor contact_quantity(const Cell& cell, const std::string& sensor, Quantity quantity, const Biases& biases) {
  const WrenchSensor wrench = contact_wrench(cell, sensor, biases);
  const bool about_torque = is_torque(quantity);
  const VectorSensor vector = about_torque ? torque(wrench) : force(wrench);
  const int part = static_cast<int>(quantity) - static_cast<int>(about_torque ? Quantity::kTorque : Quantity::kForce);
  return part == 0 ? norm(vector) : component(vector, part - 1);
}

RealSensor internal_force(const Cell& cell, const std::string& one_sensor, const std::string& other_sensor,
                          const Biases& biases) {
  const auto in_world = [&](const std::string& name) {
    const VectorSensor felt = force(contact_wrench(cell, name, biases));
    const auto sensor = cell.sensors.find(name);
    if (sensor == cell.sensors.end()) return felt;  // the formula itself says that it is not there
    const auto X_WB = cell.frames.pose(sensor->second.arm).value_or(Eigen::Isometry3d::Identity());
    const auto X_BS = flange_fixed_pose(cell, sensor->second.arm, sensor->second.X_FS);
    return rotate(net::Frame(X_WB), rotate(X_BS, felt));
  };
  return 0.5 * norm(in_world(one_sensor) - in_world(other_sensor));
}

State state_of(const Condition& condition, const Cell& cell, const Biases& biases) {
  switch (condition.kind) {
    case Condition::Kind::kAll:
    case Condition::Kind::kAny:
      return combined(condition, cell, biases);
    case Condition::Kind::kNot:
      return !state_of(condition.operands.front(), cell, biases);
    case Condition::Kind::kDigital: {
      const State level = digital_input(cell, condition.device);
      return condition.level ? level : !level;
    }
    case Condition::Kind::kBooleanChannel: {
      const State level = holds(channel<net::Boolean>(cell, condition.device));
      return condition.level ? level : !level;
    }
    case Condition::Kind::kRealChannel:
      return compared(channel<net::Real>(cell, condition.device), condition);
    case Condition::Kind::kGripper:
      return gripper_state(cell, condition.device, condition.state);
    case Condition::Kind::kAnalog:
      return compared(analog_input(cell, condition.device), condition);
    case Condition::Kind::kDistance:
      return compared(smallest_distance(cell, {condition.device}, {condition.other}), condition);
    case Condition::Kind::kInternalForce:
      return compared(internal_force(cell, condition.device, condition.other, biases), condition);
    case Condition::Kind::kForce:
      break;
  }
  return compared(contact_quantity(cell, condition.device, condition.quantity, biases), condition);
}

}  // namespace takt::expression
