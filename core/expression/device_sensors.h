#pragma once

#include <string>
#include <string_view>

#include "core/expression/cell.h"
#include "core/expression/state.h"

/// What the devices of a cell measure, as sensors. A name that the cell does not have gives a sensor that every check
/// refuses with the nearest name, so formulas can be written without a look at each part. Realtime: setup.
namespace takt::expression {

// Of an arm.
[[nodiscard]] JointsSensor measured_joints(const Cell& cell, const std::string& arm);      ///< rad or m
[[nodiscard]] JointsSensor measured_velocities(const Cell& cell, const std::string& arm);  ///< rad/s or m/s
[[nodiscard]] JointsSensor measured_torques(const Cell& cell, const std::string& arm);     ///< Nm; null without sensors
/// What was sent in the last cycle.
[[nodiscard]] JointsSensor commanded_joints(const Cell& cell, const std::string& arm);
[[nodiscard]] JointsSensor commanded_velocities(const Cell& cell, const std::string& arm);
/// The tool centre point in the arm's base, measured; and as commanded in the last cycle.
[[nodiscard]] FrameSensor tool_pose(const Cell& cell, const std::string& arm);
[[nodiscard]] FrameSensor commanded_tool_pose(const Cell& cell, const std::string& arm);
/// Any frame X_FM that is fixed to the flange, in the arm's base, measured.
[[nodiscard]] FrameSensor flange_fixed_pose(const Cell& cell, const std::string& arm, const Eigen::Isometry3d& X_FM);
/// Any frame X_LM that is fixed to a link of an arm, in the arm's base, measured, and its velocity there.
[[nodiscard]] FrameSensor link_fixed_pose(const Cell& cell, const std::string& arm, const std::string& link,
                                          const Eigen::Isometry3d& X_LM);
[[nodiscard]] TwistSensor link_fixed_twist(const Cell& cell, const std::string& arm, const std::string& link,
                                           const Eigen::Isometry3d& X_LM);
/// Velocity of the tool centre point in the arm's base and its axes, measured.
[[nodiscard]] TwistSensor tool_twist(const Cell& cell, const std::string& arm);

// Of a force/torque sensor, in its measuring frame: what the surroundings exert on the tool side.
[[nodiscard]] WrenchSensor raw_wrench(const Cell& cell, const std::string& sensor);
/// Without the weight of what is mounted on it.
[[nodiscard]] WrenchSensor compensated_wrench(const Cell& cell, const std::string& sensor);
/// Without weight and tared bias; a sensor that was never tared has none.
[[nodiscard]] WrenchSensor contact_wrench(const Cell& cell, const std::string& sensor, const Biases& biases = {});

/// All that contact_wrench() writes into its formula. It is worth the same as long as these are equal.
struct ContactConstants {
  std::string sensor = {}, arm = {};
  std::uint64_t frames = 0;  ///< FrameGraph::changes()
  Eigen::Isometry3d X_FS = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Isometry3d> X_WB = {};  ///< nothing: the base moves
  world::MassProperties carried = {};
  net::Wrench bias = {};

  [[nodiscard]] bool operator==(const ContactConstants& other) const;
};
/// No such sensor: nothing but its name.
[[nodiscard]] ContactConstants contact_constants(const Cell& cell, const std::string& sensor, const Biases& biases);

// Of a gripper. Outputs of the primitive GripperState: "moving", "holding", "lost", "open", "closed".
[[nodiscard]] RealSensor gripper_width(const Cell& cell, const std::string& gripper);  ///< m
[[nodiscard]] RealSensor gripper_force(const Cell& cell, const std::string& gripper);  ///< N
[[nodiscard]] State gripper_state(const Cell& cell, const std::string& gripper, const std::string& state);

// Of inputs and outputs; outputs give what they were sent last.
[[nodiscard]] State digital_input(const Cell& cell, const std::string& input);
[[nodiscard]] RealSensor analog_input(const Cell& cell, const std::string& input);  ///< in its own unit
[[nodiscard]] State digital_output(const Cell& cell, const std::string& output);
[[nodiscard]] RealSensor analog_output(const Cell& cell, const std::string& output);

/// The newest value of a channel, null when it is too old (docs/channels.md). T: any value type.
template <class T>
[[nodiscard]] Sensor<T> channel(const Cell& cell, const std::string& name);

/// The beginning of the ids of a device's primitives. Devices may have any name, ids have no '.', '/', blanks and
/// control characters: these, and the escape itself, become % and two hexadecimal digits, so that no two names
/// share an id.
[[nodiscard]] std::string id_of(std::string_view kind, std::string_view device);

}  // namespace takt::expression
