#include "core/command/motion_net.h"

#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/condition_net.h"
#include "core/motion/path_clock.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;
using net::NetDescription;

/// A sensor that has been silent for so long is not waited for.
constexpr double kSilence_s = 0.5;

Json frame_json(const Eigen::Isometry3d& X) { return net::value_to_json(net::Frame(X)); }

/// The condition, the latch that remembers it, and where the tool was when it first held.
void add_until(NetDescription& net, const MotionCommand& command, const Cell& cell, const Biases& biases) {
  std::string condition = add_condition(net, *command.until, "until", cell, biases);
  if (command.until_from > 0.0) {
    net.add("until_counts", "AtLeast", {{"b", command.until_from}});
    net.link_delayed("clock.time", "until_counts.a", 0.0);
    condition = add_gate(net, "until_now", "And", condition, "until_counts.value");
  }
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

/// 0 while a stop is wanted, else what the operator says. A channel that says nothing is a pause.
void add_target_rate(NetDescription& net, const std::string& stop, const std::string& channel) {
  if (channel.empty()) {
    net.add("target_rate", "SelectReal", {{"if_true", 0.0}, {"if_false", 1.0}});
  } else {
    net.add("override", "InputReal", {{"channel", channel}});
    net.add("override_or_none", "DefaultToReal", {{"fallback", 0.0}});
    net.link("override.value", "override_or_none.input");
    net.add("wanted_rate", "Clamp", {{"lower", 0.0}, {"upper", 1.0}});
    net.link("override_or_none.value", "wanted_rate.input");
    net.add("target_rate", "SelectReal", {{"if_true", 0.0}});
    net.link("wanted_rate.value", "target_rate.if_false");
  }
  net.link(stop, "target_rate.condition");
}

/// Path clock: runs until a stop is wanted, then brakes on the path. @return the port that says a stop is wanted.
void add_clock(NetDescription& net, const MotionCommand& command, const Cell& cell) {
  const motion::Motion& motion = *command.motion;
  net.add("cancel", "Cancel");
  std::string stop = "cancel.requested";
  if (command.until) stop = add_gate(net, "stop", "Or", "cancel.requested", "until_latch.value");
  add_target_rate(net, stop, cell.override_channel);
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
  add_clock(net, command, cell);
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
