#pragma once

#include <numbers>

namespace takt::cell {

/// Files speak of degrees, everything else of radians: one degree in rad.
inline constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace takt::cell
