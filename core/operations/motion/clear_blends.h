#pragma once

#include <vector>

#include "core/motion/leg.h"
#include "core/operations/motion/motion.h"
#include "core/operations/motion/move_plan.h"

/// Blends at the ends of a `move` (docs/planning.md). Realtime: setup.
namespace takt::operations {

/// As motion::plan_sequence(). A blend at an end of a `move` that cuts a corner into something is made smaller, down to
/// a rest at the corner, with a note "/1/blend" (index of the motion). Without a `move` nothing is looked at: what
/// collides then is for the rehearsal to say.
[[nodiscard]] Result<motion::SequencePlan> plan_clear_sequence(
    const std::vector<MotionTask>& requests, const expression::Cell& cell, const motion::ArmModel& arm,
    const kinematics::JointVector& q, const std::vector<motion::LegMaker>& makers, const Surroundings& surroundings);

/// Of a blend that is decided in the run: whether the motion with it collides with nothing that the one without it
/// keeps clear of. Machines that others move now are left out: where they will be is not known here.
/// @param from_rest, from_blend  of the same requests, begun at rest and out of the motion before
[[nodiscard]] bool is_clear_blend(const std::vector<MotionTask>& requests, const expression::Cell& cell,
                                  const motion::ArmModel& arm, const Surroundings& surroundings,
                                  const motion::SequencePlan& from_rest, const motion::SequencePlan& from_blend);

}  // namespace takt::operations
