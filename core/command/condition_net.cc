#include "core/command/condition_net.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;
using net::NetDescription;

Json frame_json(const Eigen::Isometry3d& X) { return net::value_to_json(net::Frame(X)); }
Json wrench_json(const net::Wrench& wrench) { return net::value_to_json(wrench); }
Json vector_json(const Eigen::Vector3d& v) { return net::value_to_json(net::Vector(v)); }

bool has(const NetDescription& net, const std::string& id) {
  return std::ranges::any_of(net.primitives, [&](const auto& primitive) { return primitive.id == id; });
}

/// The contact wrench of a sensor: weight and bias taken out, its components side by side.
void add_contact_wrench(NetDescription& net, const std::string& name, const Cell& cell, const Biases& biases) {
  const std::string id = id_of("sensor", name);
  const auto bias = biases.find(name);
  net.add(id + "-contact", "SubtractWrenches",
          {{"b", wrench_json(bias == biases.end() ? net::Wrench{} : bias->second)}});
  net.link(add_compensated_wrench(net, name, cell), id + "-contact.a");
  net.add(id + "-parts", "WrenchComponents");
  net.link(id + "-contact.value", id + "-parts.input");
}

/// The number that a comparison looks at. @return its port.
std::string add_quantity(NetDescription& net, const Condition& condition, const std::string& id) {
  const bool torque = is_torque(condition.quantity);
  const std::string vector = id_of("sensor", condition.device) + (torque ? "-parts.torque" : "-parts.force");
  const int component =
      static_cast<int>(condition.quantity) - static_cast<int>(torque ? Quantity::kTorque : Quantity::kForce);
  if (component == 0) {
    net.add(id + "-length", "Norm");
    net.link(vector, id + "-length.input");
    return id + "-length.value";
  }
  net.add(id + "-parts", "VectorComponents");
  net.link(vector, id + "-parts.input");
  return fmt::format("{}-parts.{}", id, "xyz"[component - 1]);
}

/// Puts the parts of a condition into a net.
class ConditionBuilder {
 public:
  ConditionBuilder(NetDescription& net, const Cell& cell, const Biases& biases)
      : net_(net), cell_(cell), biases_(biases) {}

  /// Recursion is bounded by the depth of the file that the condition came from.
  std::string add(const Condition& condition, const std::string& id) {
    switch (condition.kind) {
      case Condition::Kind::kAll:
        return add_gates(condition, id, "And");
      case Condition::Kind::kAny:
        return add_gates(condition, id, "Or");
      case Condition::Kind::kNot:
        return inverted(add(condition.operands.front(), id + "-0"), id);
      case Condition::Kind::kDigital:
        return add_level(condition, id);
      case Condition::Kind::kGripper:
        return add_gripper(condition);
      case Condition::Kind::kForce:
      case Condition::Kind::kAnalog:
        break;
    }
    net_.add(id, condition.above ? "GreaterThan" : "LessThan", {{"b", condition.threshold}});
    net_.link(condition.kind == Condition::Kind::kForce ? add_quantity(net_, condition, id) : add_analog(condition),
              id + ".a");
    return id + ".value";
  }

  /// What comparisons with force/torque sensors look at: each sensor once.
  void add_sensors(const Condition& condition) {
    for (const std::string& sensor : sensors_of(condition)) add_contact_wrench(net_, sensor, cell_, biases_);
  }

 private:
  std::string inverted(const std::string& port, const std::string& id) {
    net_.add(id + "-not", "Not");
    net_.link(port, id + "-not.input");
    return id + "-not.value";
  }

  /// A chain of two-input gates over all operands. @return the port of the result.
  std::string add_gates(const Condition& condition, const std::string& id, const char* gate) {
    std::string result = add(condition.operands.front(), id + "-0");
    for (std::size_t i = 1; i < condition.operands.size(); ++i) {
      const std::string operand = add(condition.operands[i], fmt::format("{}-{}", id, i));
      result = add_gate(net_, fmt::format("{}-gate{}", id, i), gate, result, operand);
    }
    return result;
  }

  std::string add_level(const Condition& condition, const std::string& id) {
    const std::string input = id_of("input", condition.device);
    if (!has(net_, input)) net_.add(input, "DigitalInput", {{"device", condition.device}});
    return condition.level ? input + ".value" : inverted(input + ".value", id);
  }

  std::string add_analog(const Condition& condition) {
    const std::string input = id_of("input", condition.device);
    if (!has(net_, input)) net_.add(input, "AnalogInput", {{"device", condition.device}});
    return input + ".value";
  }

  std::string add_gripper(const Condition& condition) {
    const std::string state = id_of("gripper", condition.device);
    if (!has(net_, state)) net_.add(state, "GripperState", {{"device", condition.device}});
    return state + "." + condition.state;
  }

  NetDescription& net_;
  const Cell& cell_;
  const Biases& biases_;
};

}  // namespace

std::string id_of(std::string_view kind, std::string_view device) {
  std::string id = fmt::format("{}-", kind);
  for (const char c : device) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte > 0x20 && byte != 0x7f && c != '.' && c != '/' && c != '%';
    id += plain ? std::string(1, c) : fmt::format("%{:02x}", byte);
  }
  return id;
}

std::string add_gate(NetDescription& net, const std::string& id, const char* type, const std::string& a,
                     const std::string& b) {
  net.add(id, type);
  net.link(a, id + ".a");
  net.link(b, id + ".b");
  return id + ".value";
}

void add_end(NetDescription& net, const std::string& condition) {
  net.add("end", "Termination");
  net.link(condition, "end.condition");
}

std::string add_arm_state(NetDescription& net, const std::string& arm) {
  const std::string id = id_of("state", arm);
  for (const auto& primitive : net.primitives) {
    if (primitive.id == id) return id + ".q";
  }
  net.add(id, "ArmState", {{"device", arm}});
  return id + ".q";
}

std::string add_compensated_wrench(NetDescription& net, const std::string& name, const Cell& cell) {
  const MountedSensor& sensor = cell.sensors.find(name)->second;
  const std::string id = id_of("sensor", name);
  net.add(id + "-raw", "ForceTorqueSensor", {{"device", name}});
  net.add(id + "-pose", "ForwardKinematics", {{"device", sensor.arm}, {"tool", frame_json(sensor.X_FS)}});
  net.link(add_arm_state(net, sensor.arm), id + "-pose.q");
  // Weight needs the direction of gravity only, so the arm's base stands for the world but for its orientation.
  const Eigen::Isometry3d X_WB = cell.frames.pose(sensor.arm).value_or(Eigen::Isometry3d::Identity());
  net.add(id + "-in-world", "Compose", {{"left", frame_json(X_WB)}});
  net.link(id + "-pose.frame", id + "-in-world.right");
  net.add(id + "-weight", "PayloadCompensation",
          {{"mass", sensor.tool_mass},
           {"centre", vector_json(sensor.p_SC)},
           {"gravity", vector_json(cell.gravity_W)},
           {"acceleration", vector_json(Eigen::Vector3d::Zero())}});
  net.link(id + "-raw.wrench", id + "-weight.wrench");
  net.link(id + "-in-world.value", id + "-weight.frame");
  return id + "-weight.compensated";
}

std::string add_condition(NetDescription& net, const Condition& condition, const std::string& id, const Cell& cell,
                          const Biases& biases) {
  ConditionBuilder builder(net, cell, biases);
  builder.add_sensors(condition);
  return builder.add(condition, id);
}

}  // namespace takt::command
