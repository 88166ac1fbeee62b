#include "core/command/force_net.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/command/condition_state.h"
#include "core/command/device_sensors.h"
#include "core/command/net_writer.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;
using net::NetDescription;

/// How fast a deviation from where the tool should be is taken back, 1/s.
constexpr double kHoldGain = 5.0;
/// From this share of the wanted force on there is contact; below a tenth of it there is none any more.
constexpr double kContactShare = 0.3, kReleaseShare = 0.1;
/// So long a contact may be broken before the approach begins again, s.
constexpr double kReleaseTime_s = 0.05;
/// The integral acts slowly: it only takes away what the law leaves.
constexpr double kIntegralTime_s = 1.0;
/// Of the approach velocity: how fast the tool may follow a surface that gives way.
constexpr double kMostVelocity = 5.0;
constexpr double kMostAcceleration = 0.5;  ///< m/s^2
/// Joints that move no faster than this stand, rad/s.
constexpr double kStanding = 1e-7;

Json vector_json(const Eigen::Vector3d& v) { return net::value_to_json(net::Vector(v)); }
Json frame_json(const Eigen::Isometry3d& X) { return net::value_to_json(net::Frame(X)); }

/// Writes the net part by part.
class PressWriter {
 public:
  PressWriter(const PressCommand& command, const Cell& cell, const Biases& biases)
      : command_(command), cell_(cell), biases_(biases) {}

  NetDescription write() {
    net_.name = command_.name;
    add_tool();
    add_force();
    add_ends();
    add_target();
    add_motion();
    return std::move(net_);
  }

 private:
  /// Where the tool was sent, how deep it is, and where it began.
  void add_tool() {
    tool_ = writer_.port_of(commanded_tool_pose(cell_, command_.arm).node());
    // Measured: a tool that is pressed to a side is not pressed there any more.
    net_.add("start", "SnapshotFrame", {{"trigger", true}});
    net_.link(writer_.port_of(tool_pose(cell_, command_.arm).node()), "start.input");
    net_.add("here", "FrameComponents");
    net_.link(tool_, "here.input");
    net_.add("there", "FrameComponents");
    net_.link("start.value", "there.input");
    net_.add("way", "SubtractVectors");
    net_.link("here.position", "way.a");
    net_.link("there.position", "way.b");
    net_.add("depth", "DotProduct", {{"b", vector_json(command_.direction_B)}});
    net_.link("way.value", "depth.a");
  }

  /// The force with which the tool presses along the direction, and the velocity that controls it.
  void add_force() {
    const MountedSensor& sensor = cell_.sensors.find(command_.sensor)->second;
    const VectorSensor force_S = force(contact_wrench(cell_, command_.sensor, biases_));
    const VectorSensor force_B = rotate(flange_fixed_pose(cell_, command_.arm, sensor.X_FS), force_S);
    force_ = writer_.port_of(force_B.node());
    net_.add("pressing", "DotProduct", {{"b", vector_json(-command_.direction_B)}});
    net_.link(force_, "pressing.a");
    // This gain takes the approach velocity away while the wanted force builds up, whatever the surface is like.
    net_.add("control", "ForceController",
             {{"wanted", command_.force},
              {"approach_velocity", command_.approach},
              {"contact_force", kContactShare * command_.force},
              {"release_force", kReleaseShare * command_.force},
              {"release_time", kReleaseTime_s},
              {"gain", command_.approach / command_.force},
              {"integral_time", kIntegralTime_s},
              {"velocity_max", kMostVelocity * command_.approach},
              {"acceleration_max", kMostAcceleration}});
    net_.link("pressing.value", "control.force");
    // A silent sensor has not felt anything.
    net_.add("contact_known", "DefaultToBoolean", {{"fallback", false}});
    net_.link("control.contact", "contact_known.input");
    add_latch("touched", "contact_known.value");
  }

  /// Everything that ends it, each remembered; together they are "over.value".
  void add_ends() {
    net_.add("cancel", "Cancel");
    std::string over = "cancel.requested";
    const auto ends = [&](const std::string& id, const std::string& port) {
      over = gate("over_" + id, "Or", over, port);
    };
    net_.add("too_far", "AtLeast", {{"b", command_.travel}});
    net_.link("depth.value", "too_far.a");
    ends("too_far", add_latch("too_far_latch", "too_far.value"));
    net_.add("silent", "IsNullVector");
    net_.link(force_, "silent.input");
    ends("silent", add_latch("silent_latch", "silent.value"));
    if (command_.hold) {
      net_.add("held", "OnDelay", {{"delay", *command_.hold}});
      net_.link("contact_known.value", "held.input");
      ends("held", add_latch("held_latch", "held.value"));
    }
    if (command_.drop) ends("found", add_drop());
    if (command_.path) {
      // The clock stands when it is over, so this has to come one cycle late.
      net_.add("path_over", "DefaultToBoolean", {{"fallback", false}});
      net_.link_delayed("clock.at_end", "path_over.input", false);
      ends("path", "path_over.value");
    }
    if (command_.until) ends("until", add_until());
    net_.add("over", "SetResetLatch", {{"reset", false}});
    net_.link(over, "over.set");
  }

  std::string gate(const std::string& id, const char* type, const std::string& a, const std::string& b) {
    net_.add(id, type);
    net_.link(a, id + ".a");
    net_.link(b, id + ".b");
    return id + ".value";
  }

  std::string add_latch(const std::string& id, const std::string& port) {
    net_.add(id, "SetResetLatch", {{"reset", false}});
    net_.link(port, id + ".set");
    return id + ".value";
  }

  std::string add_drop() {
    net_.add("depth_at_touch", "SnapshotReal");
    net_.link("depth.value", "depth_at_touch.input");
    net_.link("touched.value", "depth_at_touch.trigger");
    net_.add("sunk", "Subtract");
    net_.link("depth.value", "sunk.a");
    net_.link("depth_at_touch.value", "sunk.b");
    net_.add("found", "AtLeast", {{"b", *command_.drop}});
    net_.link("sunk.value", "found.a");
    // Before the touch nobody knows a depth to compare with.
    net_.add("found_or_not", "DefaultToBoolean", {{"fallback", false}});
    net_.link("found.value", "found_or_not.input");
    return add_latch("found_latch", "found_or_not.value");
  }

  /// Null stops too (row N3), but is nothing that was felt.
  std::string add_until() {
    const std::string condition = writer_.port_of(state_of(*command_.until, cell_, biases_).node());
    net_.add("until_known", "DefaultToBoolean", {{"fallback", false}});
    net_.link(condition, "until_known.input");
    add_latch("until_felt", "until_known.value");
    return condition;
  }

  /// Where the tool should be, across the direction, and how fast: the path, or where it began.
  void add_target() {
    if (!command_.path) {
      net_.add("target_twist", "ConstantTwist", {{"value", net::value_to_json(net::Twist{})}});
      target_frame_ = "start.value";
      target_twist_ = "target_twist.value";
      return;
    }
    const motion::Motion& path = *command_.path;
    net_.add("not_over", "Not");
    net_.link("over.value", "not_over.input");
    const std::string runs = gate("runs", "And", "touched.value", "not_over.value");
    add_rate(runs);
    net_.add("clock", "PathClock", {{"duration", path.duration()}, {"bounds", motion::to_json(path.clock)}});
    net_.link("rate.value", "clock.target_rate");
    net_.add("law", "TimeLaw", {{"law", motion::to_json(path.law)}});
    for (const char* port : {"time", "rate", "rate_derivative"}) {
      net_.link(std::string("clock.") + port, std::string("law.") + port);
    }
    net_.add("path", "CompositePath", {{"path", motion::to_json(path.path)}});
    for (const char* port : {"s", "ds", "dds"}) net_.link(std::string("law.") + port, std::string("path.") + port);
    target_frame_ = "path.frame";
    target_twist_ = "path.twist";
  }

  void add_rate(const std::string& runs) {
    net_.add("rate", "SelectReal", {{"if_false", 0.0}});
    net_.link(runs, "rate.condition");
    if (cell_.override_channel.empty()) {
      net_.add("planned_rate", "ConstantReal", {{"value", 1.0}});
      net_.link("planned_rate.value", "rate.if_true");
    } else {
      net_.add("override", "InputReal", {{"channel", cell_.override_channel}});
      net_.link("override.value", "rate.if_true");
    }
  }

  /// Twist of the tool: across the direction after the target, along it as the force wants; nothing once it is over.
  void add_motion() {
    net_.add("off", "FrameDifference");
    net_.link(tool_, "off.from");
    net_.link(target_frame_, "off.to");
    net_.add("back", "ScaleTwist", {{"factor", kHoldGain}});
    net_.link("off.value", "back.twist");
    net_.add("follow", "AddTwists");
    net_.link("back.value", "follow.a");
    net_.link(target_twist_, "follow.b");
    net_.add("follow_parts", "TwistComponents");
    net_.link("follow.value", "follow_parts.input");
    net_.add("split", "SplitVector", {{"direction", vector_json(command_.direction_B)}});
    net_.link("follow_parts.linear", "split.input");
    net_.add("push", "ScaleVector", {{"vector", vector_json(command_.direction_B)}});
    net_.link("control.velocity", "push.factor");
    net_.add("linear", "AddVectors");
    net_.link("split.across", "linear.a");
    net_.link("push.value", "linear.b");
    net_.add("twist", "AssembleTwist");
    net_.link("linear.value", "twist.linear");
    net_.link("follow_parts.angular", "twist.angular");
    net_.add("goes", "Not");
    net_.link("over.value", "goes.input");
    net_.add("gate", "GateTwist");
    net_.link("twist.value", "gate.input");
    net_.link("goes.value", "gate.open");
    const MountedArm& arm = cell_.arms.find(command_.arm)->second;
    net_.add("joints", "DifferentialInverseKinematics", {{"device", command_.arm}, {"tool", frame_json(arm.X_FT)}});
    net_.link("gate.value", "joints.twist");
    net_.add("arm", "ArmCommand", {{"device", command_.arm}});
    for (const char* port : {"q", "dq", "ddq"}) net_.link(std::string("joints.") + port, std::string("arm.") + port);
    add_standstill();
  }

  /// The net ends when the joints stand.
  void add_standstill() {
    net_.add("fastest", "LargestJoint");
    net_.link("joints.dq", "fastest.input");
    net_.add("hardest", "LargestJoint");
    net_.link("joints.ddq", "hardest.input");
    net_.add("slow", "AtMost", {{"b", kStanding}});
    net_.link("fastest.value", "slow.a");
    net_.add("free", "AtMost", {{"b", kStanding}});
    net_.link("hardest.value", "free.a");
    const std::string stands = gate("stands", "And", "slow.value", "free.value");
    net_.add("end", "Termination");
    net_.link(gate("stopped", "And", "over.value", stands), "end.condition");
  }

  const PressCommand& command_;
  const Cell& cell_;
  const Biases& biases_;
  NetWriter writer_;  ///< for formulas over sensors
  NetDescription& net_ = writer_.net;
  std::string tool_, force_, target_frame_, target_twist_;
};

}  // namespace

NetDescription press_net(const PressCommand& command, const Cell& cell, const Biases& biases) {
  return PressWriter(command, cell, biases).write();
}

}  // namespace takt::command
