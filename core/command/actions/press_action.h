#pragma once

#include <memory>
#include <optional>

#include "core/command/actions/online_action.h"
#include "core/command/actions/planned_path.h"

namespace takt::command {

struct PressWish {
  ForceWish force;
  double travel = 0.05;             ///< m along the direction that it is sent at most, from where it begins
  std::optional<double> sink = {};  ///< m deeper than where it touched, as measured
  /// Planned path of the tool centre point, Cartesian and in the base, begun with the touch; null: none. What it does
  /// along the direction does not count.
  std::shared_ptr<const motion::Motion> path = {};
  ClockInputs clock = {};  ///< of the path; at a speed of 0, or unknown, the approach stands too
  /// Of an arm on springs: by how much the tool gives way to a force along the direction, m/N. The law is made as much
  /// faster as the force is slower, and the set point, not the tool, is held across. Nothing: the arm is stiff.
  std::optional<double> softness = {};
};

/// Moves along a direction of the base until something is touched, then presses with a force and follows the path
/// across the direction. The orientation and, without a path, the place across are held: of a stiff arm the measured
/// ones. It goes on until it is cancelled.
/// @param pressing   with which the tool presses along the direction, N (pressing_force)
/// @param direction  of the force that the tool exerts, in the base; of length 1
/// Offers `in_contact`; `touched`: there was contact; `at_force`: since the last touch the force was brought up;
/// `too_far`: `travel` is used up; `sunk`: so deep; `path_ended`; `error`: the force is not known, so it comes to rest.
/// Realtime: setup.
[[nodiscard]] Action press(const RealSensor& pressing, const Eigen::Vector3d& direction_B, const PressWish& wish);

}  // namespace takt::command
