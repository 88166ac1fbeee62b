#pragma once

#include "core/command/action.h"
#include "core/command/actions/force_control_parameters.h"
#include "core/command/actions/tracking.h"

/// Actions that find their set points in the cycle, from sensors; they need no plan and go on until they are cancelled,
/// and come to rest then. Realtime: setup.
namespace takt::command {

/// Manual control: the tool centre point moves with a velocity in the axes of the base while a dead-man switch is held.
/// When the switch falls, does not answer, or the velocity is not there, the arm comes to rest within its limits.
[[nodiscard]] Action jog(const expression::TwistSensor& velocity, const expression::State& enabled,
                         const TrackingParameters& bounds = {});

/// The tool centre point follows a pose in the arm's base: the velocity of the target, and a gain on the difference
/// between target and set point; without a target it comes to rest. Offers `arrived`, `error`: there is no target.
[[nodiscard]] Action follow(const expression::FrameSensor& target, const TrackingParameters& parameters = {});

/// The joints go to a target that may change in every cycle, as fast as shares of their limits allow; without a target
/// to the last one. Offers `arrived`, `error`: there is no target.
[[nodiscard]] Action follow(const expression::JointsSensor& target, double velocity = 1.0, double acceleration = 1.0);

/// Presses along a direction, in the axes of a task frame that is given in the arm's base.
/// @param pressing  with which the tool presses along that direction, N (pressing_force)
/// Offers `in_contact`, `at_force`, `error`: the force is not known; then the arm comes to rest.
[[nodiscard]] Action hold_force(const expression::RealSensor& pressing, const expression::FrameTerm& X_BT,
                                const Eigen::Vector3d& direction_T, const ForceControlParameters& parameters = {});

/// With how much force a tool presses along a direction of the base: a sensor on the arm's flange feels the opposite.
[[nodiscard]] expression::RealSensor pressing_force(const expression::Cell& cell, const std::string& sensor,
                                                    const Eigen::Vector3d& direction_B,
                                                    const expression::Biases& biases = {});

/// The part of the same force that is across the direction, N, above 30 Hz smoothed.
[[nodiscard]] expression::RealSensor lateral_force(const expression::Cell& cell, const std::string& sensor,
                                                   const Eigen::Vector3d& direction_B,
                                                   const expression::Biases& biases = {});

}  // namespace takt::command
