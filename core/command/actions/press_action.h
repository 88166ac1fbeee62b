#pragma once

#include <memory>
#include <optional>

#include "core/command/actions/online_action.h"
#include "core/command/actions/planned_path.h"

namespace takt::command {

struct PressControlParameters {
  ForceControlParameters force;
  double travel = 0.05;                ///< m along the direction that it is sent at most, from where it begins
  std::optional<double> sink = {};     ///< m deeper than where it touched, as measured
  std::optional<double> deepest = {};  ///< m likewise: more than was expected
  /// Force across the direction, N, and what it is at most.
  struct Lateral {
    expression::RealSensor force;
    double most;
  };
  std::optional<Lateral> lateral = {};
  /// Planned path of the tool centre point, Cartesian and in the base, begun with the touch; null: none. What it does
  /// along the direction does not count.
  std::shared_ptr<const motion::Motion> path = {};
  ClockInputs clock = {};  ///< of the path; at a speed of 0, or unknown, the approach stops too
  /// Of a compliant arm: by how much a force across the direction deflects the tool, m/N. Across it the set point
  /// leads by what friction bends the springs, at most by what a friction as large as the force would. Nothing: the
  /// arm is stiff.
  std::optional<double> softness_across = {};
};

/// Moves along a direction of the base until something is touched, then presses with a force and follows the path
/// across the direction. The orientation and, without a path, the position across are held: of a stiff arm the measured
/// ones. It goes on until it is cancelled.
/// @param pressing   with which the tool presses along the direction, N (pressing_force)
/// @param direction  of the force that the tool exerts, in the base; of length 1
/// Offers `in_contact`; `touched`: there was contact; `at_force`: the force is within its band; `too_far`: `travel` is
/// used up; `sunk`, `too_deep`: so deep; `sideways`: the lateral force is too large; `path_ended`; `error`: the force
/// is not known, so it comes to rest. Realtime: setup.
[[nodiscard]] Action press(const expression::RealSensor& pressing, const Eigen::Vector3d& direction_B,
                           const PressControlParameters& parameters);

}  // namespace takt::command
