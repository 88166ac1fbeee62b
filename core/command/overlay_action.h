#pragma once

#include "core/command/online_action.h"

/// What is laid over planned motions of a frame, between their set points and the actuator. Realtime: setup.
namespace takt::command {

/// A sine beside the path, over path time: it stands while the motion is paused, and slows down with it.
struct WeaveWish {
  double amplitude = 0.002;                                ///< m
  double frequency = 2.0;                                  ///< Hz
  Eigen::Vector3d direction_M = Eigen::Vector3d::UnitY();  ///< in the axes of the frame that moves; length 1
  double ramp = 0.5;  ///< path time in which it grows from the start and fades to the end, s
};

/// The motion with a weave. Only motions of a frame (LIN, CIRC, splines of poses) can weave; a weave faster than what
/// plans leave of the Cartesian limits is refused. Offers what the motion offers.
[[nodiscard]] Action weave(const Action& motion, const WeaveWish& wish = {});

/// A force that is held while a path is followed, as in polishing or along a seam: the path is shifted along a
/// direction of the frame that moves, as far as the force wants it and the range allows.
struct ForceOffsetWish {
  ForceWish force = {};                                    ///< with its bounds of velocity and acceleration
  double jerk_max = 10.0;                                  ///< of the offset, m/s^3
  Eigen::Vector3d direction_M = Eigen::Vector3d::UnitZ();  ///< of the force that the tool exerts; length 1
  double reach = 0.005;                                    ///< along the direction at most, m, >= 0
  double retreat = 0.005;                                  ///< against it at most, m, >= 0
};

/// The motion with a force offset. Only motions of a frame (LIN, CIRC, splines of poses), which leave the offset what
/// it may need of the limits: what velocity, acceleration (MotionWish::acceleration below 1) and jerk of the path and
/// of the offset come to together is looked at joint by joint all along the path, and refused where it is too much.
///
/// A motion that is paused goes on holding the force. While the force is not known the offset comes to rest and stays,
/// and the motion stands on its path (row N3). At the end, and after a cancel, both come to rest: where that is shows
/// in the run.
/// @param pressing  with which the tool presses along the direction, N (pressing_along)
/// Offers what the motion offers, `in_contact`, and `no_force`: the force is not known.
[[nodiscard]] Action force_offset(const Action& motion, const RealSensor& pressing, const ForceOffsetWish& wish = {});

/// With how much force a tool presses along a direction of a frame M that is fixed to the flange: a sensor on that arm
/// feels the opposite. @param X_FM  M in the flange, m
[[nodiscard]] RealSensor pressing_along(const Cell& cell, const std::string& sensor, const Eigen::Vector3d& direction_M,
                                        const Eigen::Isometry3d& X_FM, const Biases& biases = {});

}  // namespace takt::command
