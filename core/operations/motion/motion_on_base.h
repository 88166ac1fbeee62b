#pragma once

#include "core/command/actions/motion_action.h"
#include "core/operations/motion/motion.h"

namespace takt::operations {

/// "lin" with "base_to": the tool goes on a straight line in the room while the base that carries the arm drives to a
/// goal of its own; both on one clock.
/// @param places  from where both go, rad or m; machines are where they are then
/// @return the motion of the base, with that of the arm as its partner; or diagnostics below the motion. Realtime:
/// setup.
[[nodiscard]] Result<command::PlannedMotion> plan_on_base(const MotionTask& motion, const expression::Cell& now,
                                                          const expression::Places& places);

}  // namespace takt::operations
