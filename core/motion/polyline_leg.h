#pragma once

#include <vector>

#include "core/motion/leg.h"

namespace takt::motion {

/// Straight lines of the joints from q_start through points, the last one the goal, with rounded corners.
/// @param corners  for each point but the last: the share of the shorter of the two lines at it that its corner takes
/// of both, in (0, 0.5]
/// @return one piece for each line and each corner: the pieces 1, 3, ... are corners. Or diagnostics: "/start",
/// "/points/2" (size, range, the same as the one before), "/corners". Realtime: setup, deterministic.
[[nodiscard]] Result<Leg> polyline_leg(const ArmModel& arm, const JointVector& q_start,
                                       const std::vector<JointVector>& points, const std::vector<double>& corners);

/// Bound of |dq/du| by joint over the whole curve: what the control points of its derivative allow (Bezier).
[[nodiscard]] JointVector fastest_of(const JointCurve& curve);

}  // namespace takt::motion
