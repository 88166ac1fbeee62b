#pragma once

#include <optional>

#include "core/motion/leg.h"

namespace takt::motion {

/// What the joints do at path time `tau` (s) of a planned motion that runs at rate 1: q, dq, ddq. Where the path is
/// Cartesian, inverse kinematics follows it from its start, on the branch of the plan.
/// @return nothing where it cannot be followed, which no plan lets happen. Realtime: setup, deterministic.
[[nodiscard]] std::optional<JointSample> joints_at(const ArmModel& arm, const Motion& motion, double tau);

}  // namespace takt::motion
