#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/activity/activity_model.h"
#include "core/activity/motion_options.h"
#include "core/activity/scheduler.h"
#include "core/command/actions/overlay_action.h"
#include "core/command/actions/weave_plan.h"

namespace takt::activity {

/// A force offset over one motion and those after it.
struct OffsetPlan {
  expression::RealSensor pressing;
  command::ForceOffsetControlParameters parameters;
  std::size_t first = 0;  ///< of the motions that it is made of
};

/// A motion that is planned twice: from rest, and, where it can go on with another one, from a blend. One clock, one or
/// several arms.
struct DualEntryMotion {
  std::string name;
  command::Actuator actuator;
  std::string clock;  ///< the arm in whose channels its clock is shown
  command::PlannedMotion from_rest;
  std::optional<command::PlannedMotion> from_blend = {};
  double tau = 0.0;  ///< path time of the predecessor at which that one begins, s
  /// How each arm is taken over.
  struct Begin {
    device::Seam rest;
    std::optional<device::Seam> blend;
  };
  std::map<std::string, Begin> begins = {};
  /// What must not hold while one of the motions that it is made of is being done: it brakes on its path then, and
  /// guarded_end() reports it. One for each motion, or none at all.
  std::vector<std::optional<expression::State>> abort_if = {};
  /// What is laid over it for either entry; nothing: the set points are those of the plan.
  std::optional<command::WeavePlan> weaves_from_rest = {}, weaves_from_blend = {};
  std::optional<OffsetPlan> offset = {};
};

/// The plans of a motion of one arm.
struct ArmPlans {
  std::string name, arm;
  const motion::ArmModel& model;
  motion::SequencePlan from_rest;
  std::optional<motion::SequencePlan> from_blend;
  std::vector<std::optional<expression::State>> abort_if = {};
  command::Weaves weaves = {};  ///< of each of its motions; empty: none
  std::optional<OffsetPlan> offset = {};
};

/// One command with both entries, of which the first cycle takes one by where the clock's arm is sent to (docs/
/// activity-layer.md), and what is known of its arms. Realtime: setup.
[[nodiscard]] PlannedActivity prepare_dual_entry(const PlanningContext& planning, DualEntryMotion motion,
                                                 const MotionOptions& options);

/// The same for one arm. What is laid over its first or its last motion begins and ends at rest: that one is not joined
/// or left in motion. @return diagnostics of plan_weaves() from rest, "/1/ramp" (index of the motion), and of the
/// offset
[[nodiscard]] Result<PlannedActivity> prepare_dual_entry(const PlanningContext& planning, ArmPlans plans,
                                                         const MotionOptions& options);
/// What may be left, as planners have it; nothing where the arm has to come to rest first. It refers to `before`.
/// @param X_FM  the frame that is to move on
[[nodiscard]] std::optional<motion::Departure> departure_of(const Predecessor& before, const Eigen::Isometry3d& X_FM);

/// How a guarded motion ended.
struct GuardedOutcome {
  enum class Kind : std::uint8_t {
    kTouched,       ///< its condition held, and it braked on its path
    kNotTouched,    ///< it came to its goal, and the condition never held
    kSensorSilent,  ///< it was unknown whether the condition holds, and it braked on its path (row N3)
    kInterrupted    ///< it was cancelled before any of these, or is not over
  };
  Kind kind = Kind::kInterrupted;
  /// Of a touch: the tool in the arm's base, measured, in the cycle in which the condition first held, m.
  std::optional<net::Frame> X_BT = {};
  /// Of a touch, N: what the force/torque sensor in the condition felt in that cycle, in the frame in which the
  /// condition has it; nothing: there is none in the condition.
  std::optional<Eigen::Vector3d> force = {};

  [[nodiscard]] bool touched() const { return kind == Kind::kTouched; }
};
[[nodiscard]] std::string_view name_of(GuardedOutcome::Kind kind);
/// Of one motion, or a sequence that is one, with a condition (MotionOptions::until). Realtime: setup.
[[nodiscard]] GuardedOutcome guarded_outcome(const RunView& run);

/// How a motion ended that shows it (DualEntryMotion::until, DualEntryMotion::abort_if).
struct GuardedEnd {
  GuardedOutcome outcome;  ///< of a motion with a condition
  /// What must not hold did, or was unknown.
  struct Broken {
    int motion = 0;  ///< of those that it is made of; -1: of the one that it went on with
    bool silent = false;
    std::string compared = {};  ///< compared_text()
  };
  std::optional<Broken> broken;
  bool no_force = false;  ///< with a force offset: the force was not known any more
  /// With a force offset: where on the path, 0 to 1, contact or the band of the force had been left for too long.
  std::optional<double> lost = {}, off_force = {};
};
/// @param motions  that it is made of
[[nodiscard]] GuardedEnd guarded_end(const RunView& run, int motions = 1);

/// The seam of a motion that runs at rate 1.
[[nodiscard]] device::Seam seam_of(const motion::JointSample& state);
[[nodiscard]] device::Seam seam_at_rest(const kinematics::JointVector& q);
/// How an arm is taken over in motion; under an override only the guard knows whether it fits.
[[nodiscard]] device::Seam seam_in_motion(const Predecessor::BlendOut& leaving, const motion::JointSample& begin);

}  // namespace takt::activity
