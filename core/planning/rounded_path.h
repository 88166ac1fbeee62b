#pragma once

#include <vector>

#include "core/motion/polyline_leg.h"
#include "core/planning/free_space.h"

namespace takt::planning {

/// A free path of straight lines with corners that are as round as they can be and stay free: what the arm can follow
/// without stopping.
/// @param points  start and goal included   @return the geometry; or diagnostics: as of motion::polyline_leg(), or
/// kPlanningFailed: a corner cannot be rounded. Realtime: setup, deterministic.
[[nodiscard]] Result<motion::Leg> rounded_path(FreeSpace& space, const motion::ArmModel& arm,
                                               const std::vector<JointVector>& points);

}  // namespace takt::planning
