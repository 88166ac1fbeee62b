#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/activity/motion_activity.h"

namespace takt::activity {

/// A motion that is planned twice: from rest, and, where it can go on with another one, from a blend. One clock, one or
/// several arms.
struct TwoWays {
  std::string name;
  command::Actuator actuator;
  std::string clock;  ///< the arm in whose channels its clock is told
  command::PlannedMotion from_rest;
  std::optional<command::PlannedMotion> from_blend = {};
  double tau = 0.0;  ///< path time of the predecessor at which that one begins, s
  /// How each arm is taken over.
  struct Begin {
    device::Seam rest;
    std::optional<device::Seam> blend;
  };
  std::map<std::string, Begin> begins = {};
};

/// One command with both ways, of which the first cycle takes one by where the clock's arm is told to be (docs/
/// activity-layer.md), and what is known of its arms. Realtime: setup.
[[nodiscard]] Prepared prepare_two_ways(const Situation& situation, TwoWays ways, const MotionParameters& wish);

/// The seam of a motion that runs at rate 1.
[[nodiscard]] device::Seam seam_of(const motion::JointSample& state);
[[nodiscard]] device::Seam seam_at_rest(const kinematics::JointVector& q);
/// How an arm is taken over in motion; under an override only the guard can tell whether it fits.
[[nodiscard]] device::Seam seam_in_motion(const Precedent::Leaving& leaving, const motion::JointSample& begin);

}  // namespace takt::activity
