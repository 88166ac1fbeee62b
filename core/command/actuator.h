#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/device/control_mode.h"
#include "core/expression/cell.h"
#include "core/expression/net_writer.h"
#include "core/expression/state.h"

namespace takt::command {

/// What an action hands to an actuator in each cycle.
enum class SetPointKind : std::uint8_t {
  kJoints,   ///< q, dq, ddq (Joints)
  kPose,     ///< frame, twist, acceleration, held, held_velocity, held_acceleration of M in the actuator's base
  kPath,     ///< joints on some pieces, a pose on others: the ports of both, and `cartesian`, which says where it is
  kTwist,    ///< twist of M at its origin, in the axes of the base
  kBoolean,  ///< value
  kReal,     ///< value
  kGrip,     ///< width, speed, force
  kPair      ///< of two arms: the set points of both, as `parts`
};
[[nodiscard]] std::string_view name_of(SetPointKind kind);

/// How fast a tool may be, m/s and rad/s.
struct ToolSpeed {
  double linear = 0.0, angular = 0.0;
};

/// A set point in a fragment: each of its ports is an output in there, a constant, or a sensor.
struct SetPoint {
  SetPointKind kind = SetPointKind::kJoints;
  std::map<std::string, std::string, std::less<>> ports;                 ///< name above, "id.port" in the fragment
  std::map<std::string, nlohmann::ordered_json, std::less<>> constants;  ///< name above, value
  std::map<std::string, expression::ExpressionPtr, std::less<>> sensors = {};  ///< name above, what it follows
  Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();                      ///< of pose and twist: M in the flange
  std::optional<ToolSpeed> speed = {};  ///< of a twist: no set point makes M faster
  std::vector<SetPoint> parts = {};     ///< of a pair: joints or pose of each
  /// Of arms: the control mode that it is meant for; nothing: whichever the arm is in. For a mode of impedance there
  /// may be beside the ports above what the arm is to be like as a spring: "stiffness", "damping_ratio", "torque"; or
  /// "stiffness", "rotational_stiffness", "damping_ratio", "wrench", "nullspace_stiffness" (docs/control-modes.md).
  std::optional<device::ControlMode> mode = {};
  bool in_tool_axes = false;  ///< of Cartesian impedance: stiffness and wrench, else in those of the base

  /// Joins one of its ports with an input in the fragment.
  void feed(expression::FragmentWriter& fragment, std::string_view name, const std::string& to) const;
};

class Actuator;

/// What is known of something that can be commanded; knows no action. Immutable; any thread.
class ActuatorModel {
 public:
  explicit ActuatorModel(std::string name) : name_(std::move(name)) {}
  virtual ~ActuatorModel() = default;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// The devices that a command on it drives; commands that share one may not run together (rule C7).
  [[nodiscard]] virtual std::vector<std::string> devices() const { return {name_}; }
  /// The kinds of set points that it takes, as they are or by a conversion of its own.
  [[nodiscard]] virtual std::vector<SetPointKind> takes() const = 0;
  /// The control modes in which it follows set points; nothing: it knows none.
  [[nodiscard]] virtual std::vector<device::ControlMode> modes() const { return {}; }
  /// Adds what takes the set point: conversion and driver. `set_point.kind` is one of takes(), its mode one
  /// of modes().
  virtual void add_consumer(expression::FragmentWriter& fragment, const SetPoint& set_point) const = 0;
  /// States of its own: "completed" (it has reached its last command), "emergency_stop" (it accepts nothing).
  [[nodiscard]] virtual std::map<std::string, expression::State> states() const = 0;
  /// Adds what is true while the set point that its consumer is fed with in this fragment is none. @return its port.
  [[nodiscard]] virtual std::string add_invalid(expression::FragmentWriter& fragment) const = 0;
  /// The arm that it is; null for others, and for two arms as one.
  [[nodiscard]] virtual const expression::MountedArm* arm() const { return nullptr; }
  /// The arms that it moves, in the order of devices(); empty for others.
  [[nodiscard]] virtual std::vector<const expression::MountedArm*> arms() const;
  /// Those of them that take a compliance: of an arm on a base the arm alone.
  [[nodiscard]] virtual std::vector<const expression::MountedArm*> compliant_arms() const { return arms(); }
  /// The joint of arm() that it is; nothing: it is more than that.
  [[nodiscard]] virtual std::optional<int> joint() const { return std::nullopt; }
  /// The actuators that it is made of, for who asks which of them an action is for; empty: it is one itself.
  [[nodiscard]] virtual std::vector<Actuator> parts() const;
  /// The rate at which people want what moves its arms to run, [0, 1]: the speed of the slowest of them
  /// (speed_channel()) times the cell's override. 0 or null: it stops. Nothing: the cell has no such channels, or it
  /// moves no arm.
  [[nodiscard]] virtual std::optional<expression::RealSensor> speed() const { return std::nullopt; }
  /// What is known of the gripper, or the analog output, that it is; null for others.
  [[nodiscard]] virtual const device::GripperDescription* gripper() const { return nullptr; }
  [[nodiscard]] virtual const device::SignalOutputDescription<double>* analog_output() const { return nullptr; }
  /// Why it is invalid, with the location below its command: a device that the cell does not have.
  [[nodiscard]] virtual std::optional<Diagnostic> fault() const { return std::nullopt; }

 private:
  std::string name_;
};

/// Something that can be commanded: an arm, a gripper, an output. A cheap value. Any thread.
class Actuator {
 public:
  explicit Actuator(std::shared_ptr<const ActuatorModel> model) : model_(std::move(model)) {}

  [[nodiscard]] const std::string& name() const { return model_->name(); }
  [[nodiscard]] const ActuatorModel& model() const { return *model_; }
  /// It has reached its last command.
  [[nodiscard]] expression::State completed() const;
  /// A command of the same tree gives it a set point that is none: no joints for a pose, a sensor that is silent. The
  /// net fails in that cycle (row N4); what the state starts or reports outside still happens in it.
  [[nodiscard]] expression::State invalid_set_point() const;
  /// It takes no set points: an emergency stop, no power, a fault.
  [[nodiscard]] expression::State emergency_stop() const;

 private:
  std::shared_ptr<const ActuatorModel> model_;
};

/// The channel by which people set the speed of whatever moves an arm: 1; [0, 1].
[[nodiscard]] std::string speed_channel(const std::string& arm);

// The actuators of a cell, by the name of the device. A name that is not there gives one that every check refuses.
// Realtime: setup; the devices outlive them.
[[nodiscard]] Actuator arm(const expression::Cell& cell, const std::string& name);
[[nodiscard]] Actuator gripper(const expression::Cell& cell, const std::string& name);
/// One joint of an arm, while the others rest: takes PTP with a goal of one number, rad or m. @param index  from 0
[[nodiscard]] Actuator joint(const expression::Cell& cell, const std::string& arm, int index);
/// Several actuators as one thing with a name: a robot with its torch. A command on it is one on the only part that
/// takes what its action gives; where there are none, or several, checks refuse it.
[[nodiscard]] Actuator composed(std::string name, const std::vector<Actuator>& parts);
/// Two arms as one: "leader+follower". A set point that is none for one of them is none for both.
[[nodiscard]] Actuator arm_pair(const expression::Cell& cell, const std::string& leader, const std::string& follower);
/// The same of an arm and what carries it, "base+arm": only the arm takes a compliance, its base stays stiff.
[[nodiscard]] Actuator carried_pair(const expression::Cell& cell, const std::string& base, const std::string& rider);
[[nodiscard]] Actuator output(const expression::Cell& cell, const std::string& name);
/// What cannot be: every check refuses it with this diagnostic.
[[nodiscard]] Actuator missing(std::string name, Diagnostic why);

}  // namespace takt::command
