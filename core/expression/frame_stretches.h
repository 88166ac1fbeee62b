#pragma once

#include <vector>

#include "core/motion/planner.h"

/// Where on its path clock a planned motion is one of a frame. Realtime: setup.
namespace takt::expression {

struct Interval {
  double begin = 0.0, end = 0.0;  ///< path time, s
};
[[nodiscard]] Interval common(const Interval& a, const Interval& b);
/// It is not empty, and no rounding.
[[nodiscard]] bool is_some(const Interval& interval);

/// When a motion is one of the frame, and not of joints: in order, apart.
[[nodiscard]] std::vector<Interval> stretches_of_frame(const motion::Motion& motion);

}  // namespace takt::expression
