#include "core/command/motion_net.h"

#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/motion/path_clock.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;
using net::NetDescription;

/// A sensor that has been silent for so long is not waited for.
constexpr double kSilence_s = 0.5;

Json frame_json(const Eigen::Isometry3d& X) { return net::value_to_json(net::Frame(X)); }
Json wrench_json(const net::Wrench& wrench) { return net::value_to_json(wrench); }
Json vector_json(const Eigen::Vector3d& v) { return net::value_to_json(net::Vector(v)); }

/// The beginning of the ids of a device's primitives. Devices may have any name, ids have no '.', '/', blanks and
/// control characters: these, and the escape itself, stand as % and two hexadecimal digits, so that no two names share
/// an id.
std::string id_of(std::string_view kind, std::string_view device) {
  std::string id = fmt::format("{}-", kind);
  for (const char c : device) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte > 0x20 && byte != 0x7f && c != '.' && c != '/' && c != '%';
    id += plain ? std::string(1, c) : fmt::format("%{:02x}", byte);
  }
  return id;
}

/// A two-input gate over two ports. @return the port of the result.
std::string add_gate(NetDescription& net, const std::string& id, const char* type, const std::string& a,
                     const std::string& b) {
  net.add(id, type);
  net.link(a, id + ".a");
  net.link(b, id + ".b");
  return id + ".value";
}

/// The net ends when the port is true.
void add_end(NetDescription& net, const std::string& condition) {
  net.add("end", "Termination");
  net.link(condition, "end.condition");
}

/// Measured positions of an arm, one primitive however many ask. @return the port of q.
std::string add_arm_state(NetDescription& net, const std::string& arm) {
  const std::string id = id_of("state", arm);
  for (const auto& primitive : net.primitives) {
    if (primitive.id == id) return id + ".q";
  }
  net.add(id, "ArmState", {{"device", arm}});
  return id + ".q";
}

/// A sensor's reading without the weight of what hangs on it. @return the port of the wrench.
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
  const std::string vector = id_of("sensor", condition.sensor) + (torque ? "-parts.torque" : "-parts.force");
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

std::string add_condition(NetDescription& net, const Condition& condition, const std::string& id);

/// A chain of two-input gates over all operands. @return the port of the result.
std::string add_gates(NetDescription& net, const Condition& condition, const std::string& id, const char* gate) {
  std::string result = add_condition(net, condition.operands.front(), id + "-0");
  for (std::size_t i = 1; i < condition.operands.size(); ++i) {
    const std::string operand = add_condition(net, condition.operands[i], fmt::format("{}-{}", id, i));
    result = add_gate(net, fmt::format("{}-gate{}", id, i), gate, result, operand);
  }
  return result;
}

/// Recursion is bounded by the depth of the file that the condition came from.
std::string add_condition(NetDescription& net, const Condition& condition, const std::string& id) {
  if (condition.kind == Condition::Kind::kAll) return add_gates(net, condition, id, "And");
  if (condition.kind == Condition::Kind::kAny) return add_gates(net, condition, id, "Or");
  if (condition.kind == Condition::Kind::kNot) {
    net.add(id + "-not", "Not");
    net.link(add_condition(net, condition.operands.front(), id + "-0"), id + "-not.input");
    return id + "-not.value";
  }
  net.add(id, condition.above ? "GreaterThan" : "LessThan", {{"b", condition.threshold}});
  net.link(add_quantity(net, condition, id), id + ".a");
  return id + ".value";
}

/// The condition, the latch that remembers it, and where the tool was when it first held.
void add_until(NetDescription& net, const MotionCommand& command, const Cell& cell, const Biases& biases) {
  for (const std::string& sensor : sensors_of(*command.until)) add_contact_wrench(net, sensor, cell, biases);
  const std::string condition = add_condition(net, *command.until, "until");
  net.add("until_latch", "SetResetLatch", {{"reset", false}});
  net.link(condition, "until_latch.set");
  // A sensor that is silent stops the arm, but it has not felt anything.
  net.add("felt", "DefaultToBoolean", {{"fallback", false}});
  net.link(condition, "felt.input");
  net.add("touch_latch", "SetResetLatch", {{"reset", false}});
  net.link("felt.value", "touch_latch.set");
  const MountedArm& arm = cell.arms.find(command.arm)->second;
  net.add("tool_pose", "ForwardKinematics", {{"device", command.arm}, {"tool", frame_json(arm.X_FT)}});
  net.link(add_arm_state(net, command.arm), "tool_pose.q");
  net.add("touch_frame", "SnapshotFrame");
  net.link("tool_pose.frame", "touch_frame.input");
  net.link("touch_latch.value", "touch_frame.trigger");
}

/// Path clock: runs until a stop is wanted, then brakes on the path. @return the port that says a stop is wanted.
void add_clock(NetDescription& net, const MotionCommand& command) {
  const motion::Motion& motion = *command.motion;
  net.add("cancel", "Cancel");
  std::string stop = "cancel.requested";
  if (command.until) stop = add_gate(net, "stop", "Or", "cancel.requested", "until_latch.value");
  net.add("target_rate", "SelectReal", {{"if_true", 0.0}, {"if_false", 1.0}});
  net.link(stop, "target_rate.condition");
  net.add("clock", "PathClock", {{"duration", motion.duration()}, {"bounds", motion::to_json(motion.clock)}});
  net.link("target_rate.value", "clock.target_rate");
  const std::string stopped = add_gate(net, "stopped", "And", stop, "clock.standstill");
  add_end(net, add_gate(net, "done", "Or", "clock.at_end", stopped));
}

void link_all(NetDescription& net, const std::string& from, const std::string& to,
              std::initializer_list<const char*> ports) {
  for (const char* port : ports) net.link(from + "." + port, to + "." + port);
}

constexpr std::initializer_list<const char*> kFramePorts = {"frame", "twist",         "acceleration",
                                                            "held",  "held_velocity", "held_acceleration"};
constexpr std::initializer_list<const char*> kJointPorts = {"q", "dq", "ddq"};

void add_inverse(NetDescription& net, const MotionCommand& command) {
  net.add("inverse", "InverseKinematics", {{"device", command.arm}, {"tool", frame_json(command.X_FM)}});
}

/// Inverse kinematics that is active on Cartesian pieces only, so that it begins at the arm's set point whenever the
/// path enters one; else the joints of the path. Their ports are those of the selections.
void add_both_spaces(NetDescription& net, const MotionCommand& command) {
  net::FragmentDescription follow;
  follow.id = "follow_frame";
  follow.when_inactive = net::WhenInactive::kReset;
  add_inverse(follow.net, command);
  for (const char* port : kFramePorts) follow.inputs.emplace_back(port, std::string("inverse.") + port);
  for (const char* port : kJointPorts) follow.outputs.emplace_back(port, std::string("inverse.") + port);
  net.fragments.push_back(std::move(follow));
  net.link("path.cartesian", "follow_frame.active");
  for (const char* port : kFramePorts) net.link(std::string("path.") + port, std::string("follow_frame.") + port);
  for (const char* port : kJointPorts) {
    const std::string id = std::string("choose_") + port;
    net.add(id, "SelectJoints");
    net.link("path.cartesian", id + ".condition");
    net.link(std::string("follow_frame.") + port, id + ".if_true");
    net.link(std::string("path.") + port, id + ".if_false");
    net.link(id + ".value", std::string("arm.") + port);
  }
}

struct PathKind {
  const char* primitive;
  bool joints, frame;  ///< what it gives
};

PathKind kind_of(const motion::Path& path) {
  if (std::holds_alternative<motion::JointLine>(path)) return {"JointLine", true, false};
  if (std::holds_alternative<motion::CartesianLine>(path)) return {"CartesianLine", false, true};
  if (std::holds_alternative<motion::CartesianArc>(path)) return {"CartesianArc", false, true};
  const auto& composite = std::get<motion::CompositePath>(path);
  return {"CompositePath", composite.has_joint_pieces(), composite.has_cartesian_pieces()};
}

/// Time law, path, inverse kinematics where it is needed, arm.
void add_path(NetDescription& net, const MotionCommand& command) {
  const motion::Motion& motion = *command.motion;
  const PathKind kind = kind_of(motion.path);
  net.add("law", "TimeLaw", {{"law", motion::to_json(motion.law)}});
  link_all(net, "clock", "law", {"time", "rate", "rate_derivative"});
  net.add("path", kind.primitive, {{"path", motion::to_json(motion.path)}});
  link_all(net, "law", "path", {"s", "ds", "dds"});
  net.add("arm", "ArmCommand", {{"device", command.arm}});
  if (kind.joints && kind.frame) return add_both_spaces(net, command);
  if (kind.joints) return link_all(net, "path", "arm", kJointPorts);
  add_inverse(net, command);
  link_all(net, "path", "inverse", kFramePorts);
  link_all(net, "inverse", "arm", kJointPorts);
}

}  // namespace

net::NetDescription motion_net(const MotionCommand& command, const Cell& cell, const Biases& biases) {
  NetDescription net;
  net.name = command.name;
  if (command.until) add_until(net, command, cell, biases);
  add_clock(net, command);
  add_path(net, command);
  return net;
}

std::int64_t cancel_bound_cycles(const motion::Motion& motion, Nanoseconds period) {
  const double stop_s = motion::PathClock(motion.clock, motion.duration(), false).stop_time_bound();
  // The net hears of the cancel one cycle after it was asked for, and the clock stands at the end of a whole cycle.
  return static_cast<std::int64_t>(std::ceil(stop_s / to_seconds(period))) + 2;
}

net::NetDescription tare_net(const std::string& sensor, std::int64_t cycles, const Cell& cell) {
  NetDescription net;
  net.name = "tare " + sensor;
  const std::string wrench = add_compensated_wrench(net, sensor, cell);
  net.add("tare", "Tare", {{"cycles", cycles}, {"trigger", true}});
  net.link(wrench, "tare.wrench");
  // Null readings are not averaged, so a dead sensor would keep the net for ever.
  net.add("parts", "WrenchComponents");
  net.link(wrench, "parts.input");
  net.add("no_force", "IsNullVector");
  net.link("parts.force", "no_force.input");
  net.add("silent", "OnDelay", {{"delay", kSilence_s}});
  net.link("no_force.value", "silent.input");
  net.add("cancel", "Cancel");
  const std::string give_up = add_gate(net, "give_up", "Or", "cancel.requested", "silent.value");
  add_end(net, add_gate(net, "done", "Or", give_up, "tare.done"));
  return net;
}

}  // namespace takt::command
