#pragma once

#include <vector>

#include "core/motion/leg.h"
#include "core/operations/motion.h"
#include "core/operations/move_plan.h"

/// Blends at the ends of a `move` (docs/planning.md). Realtime: setup.
namespace takt::activity {

/// As motion::plan_sequence(). A blend at an end of a `move` that cuts a corner into something is made smaller, down to
/// a rest at the corner, with a note "/1/blend" (index of the motion). Without a `move` nothing is looked at: what
/// collides then is for the rehearsal to say.
[[nodiscard]] Result<motion::SequencePlan> plan_clear_sequence(const std::vector<MotionTask>& requests,
                                                               const command::Cell& cell, const motion::ArmModel& arm,
                                                               const kinematics::JointVector& q,
                                                               const std::vector<motion::LegMaker>& makers,
                                                               const Surroundings& surroundings);

}  // namespace takt::activity
