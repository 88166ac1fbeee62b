#pragma once

#include <array>

#include "core/kinematics/lines.h"

namespace takt::kinematics {

/// Angles of three joints that carry a point to a goal.
struct ArmAngles {
  std::array<std::array<double, 3>, 4> angles{};
  int count = 0;
};

/// All angles of three revolute joints, with any axes, that carry `point` to `goal`; both and the axes in one frame,
/// all at zero. Up to four, each good to about 1e-8: they are roots of a polynomial of degree four. None where the
/// point cannot get there, or where two of the axes' equations are dependent (axes 1 and 2 meeting or parallel *and* 2
/// and 3 likewise: other families). Source: Pieper 1968. Realtime: cyclic, no allocation.
[[nodiscard]] ArmAngles position_angles(const std::array<Line, 6>& lines, const Eigen::Vector3d& point,
                                        const Eigen::Vector3d& goal);

}  // namespace takt::kinematics
