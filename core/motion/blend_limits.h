#pragma once

namespace takt::motion {

/// Smaller blends are refused: a corner of some micrometres is passed almost at rest, or takes hours to plan.
inline constexpr double kLeastBlend_m = 1e-5;
inline constexpr double kLeastBlendShare = 1e-4;
inline constexpr double kMostBlendShare = 0.5;  ///< of a motion, so that the blends at both ends always fit

}  // namespace takt::motion
