#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/base/diagnostics.h"

namespace takt::collision {

struct HullMesh {
  std::vector<Eigen::Vector3d> corners;
  std::vector<int> triangles;  ///< three indices each, counter-clockwise seen from outside
};

/// The convex hull of points by Qhull, triangulated. The same points give the same hull.
/// @return the hull, or a diagnostic: fewer than four points, all in one plane, not finite. Realtime: setup.
[[nodiscard]] Result<HullMesh> convex_hull(std::span<const Eigen::Vector3d> points);

}  // namespace takt::collision
