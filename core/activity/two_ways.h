#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/activity/motion_activity.h"
#include "core/activity/scheduler.h"
#include "core/command/actions/overlay_action.h"

namespace takt::activity {

/// A force offset over one motion and those after it.
struct OffsetPlan {
  command::RealSensor pressing;
  command::ForceOffsetWish wish;
  std::size_t first = 0;  ///< of the motions that it is made of
};

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
  bool tells_end = false;  ///< a guarded motion tells how it ended (guarded_end)
  /// What must not hold while one of the motions that it is made of is being done: it brakes on its path then, and
  /// guarded_end() tells it. One for each motion, or none at all.
  std::vector<std::optional<command::State>> unless = {};
  /// What is laid over either way; nothing: the set points are those of the plan.
  std::optional<command::WeavePlan> weaves_from_rest = {}, weaves_from_blend = {};
  std::optional<OffsetPlan> offset = {};
};

/// The plans of a motion of one arm.
struct ArmPlans {
  std::string name, arm;
  const motion::ArmModel& model;
  motion::SequencePlan from_rest;
  std::optional<motion::SequencePlan> from_blend;
  bool tells_end = false;
  std::vector<std::optional<command::State>> unless = {};
  command::WeaveWishes weaves = {};  ///< of each of its motions; empty: none
  std::optional<OffsetPlan> offset = {};
};

/// One command with both ways, of which the first cycle takes one by where the clock's arm is told to be (docs/
/// activity-layer.md), and what is known of its arms. Realtime: setup.
[[nodiscard]] Prepared prepare_two_ways(const Situation& situation, TwoWays ways, const MotionParameters& wish);

/// The same for one arm. What is laid over its first or its last motion begins and ends at rest: that one is not joined
/// or left in motion. @return findings of plan_weaves() from rest, "/1/ramp" (index of the motion), and of the offset
[[nodiscard]] Result<Prepared> prepare_two_ways(const Situation& situation, ArmPlans plans,
                                                const MotionParameters& wish);
/// What may be left, as planners have it; nothing where the arm has to come to rest first. It refers to `before`.
/// @param X_FM  the frame that is to move on
[[nodiscard]] std::optional<motion::Departure> departure_of(const Precedent& before, const Eigen::Isometry3d& X_FM);

/// How a motion ended that tells it (TwoWays::tells_end, TwoWays::unless).
struct GuardedEnd {
  /// Where the tool was, in the arm's base, measured, in the cycle in which `until` first held; nothing: it never did.
  std::optional<net::Frame> touch;
  bool at_goal = false;  ///< it came to the end of its path
  /// What must not hold did, or nobody knew any more.
  struct Broken {
    int motion = 0;  ///< of those that it is made of; -1: of the one that it went on with
    bool silent = false;
  };
  std::optional<Broken> broken;
  bool no_force = false;  ///< with a force offset: the force was not known any more
};
/// @param motions  that it is made of
[[nodiscard]] GuardedEnd guarded_end(const ActivityRun& run, int motions = 1);

/// The seam of a motion that runs at rate 1.
[[nodiscard]] device::Seam seam_of(const motion::JointSample& state);
[[nodiscard]] device::Seam seam_at_rest(const kinematics::JointVector& q);
/// How an arm is taken over in motion; under an override only the guard can tell whether it fits.
[[nodiscard]] device::Seam seam_in_motion(const Precedent::Leaving& leaving, const motion::JointSample& begin);

}  // namespace takt::activity
