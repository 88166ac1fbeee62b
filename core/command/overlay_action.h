#pragma once

#include "core/command/action.h"

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

}  // namespace takt::command
