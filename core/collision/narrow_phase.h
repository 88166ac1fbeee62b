#pragma once

#include <Eigen/Geometry>

#include "core/collision/convex.h"

namespace takt::collision {

/// Two convex solids A and B, and how far they are apart.
struct Separation {
  /// m; certified: no point of A is nearer to a point of B (core/collision/README.md). 0: they overlap or touch.
  double distance = 0.0;
  Eigen::Vector3d axis_A = Eigen::Vector3d::UnitX();  ///< unit vector from A to B along which that holds, in frame A
};

/// How far A and B are apart along a direction: negative where their shadows on it overlap. Never more than their
/// distance. @param X_AB  frame of B in frame of A, m   @param axis_A  unit vector in A
/// Realtime: cyclic.
[[nodiscard]] double gap_along(const Convex& a, const Convex& b, const Eigen::Isometry3d& X_AB,
                               const Eigen::Vector3d& axis_A);

/// How much a distance may cost.
enum class Effort {
  kThorough,  ///< until the shapes confirm what the library says
  kBound,     ///< from the shapes alone, within a microsecond: good where the hint is
  kCyclic,    ///< bounded, without allocation: in rare cases the distance is too small
};

/// The distance of two solids. The library proposes an axis; the shapes themselves prove what it is worth, so a defect
/// of the library makes a distance too small and never too large.
/// @param hint  an axis of an earlier query, tried first: where it proves `enough` already, that is the answer
/// @param enough  m: a larger distance need not be exact
/// Realtime: cyclic with Effort::kCyclic, else any thread.
[[nodiscard]] Separation separation(const Convex& a, const Convex& b, const Eigen::Isometry3d& X_AB,
                                    const Eigen::Vector3d& hint, double enough, Effort effort = Effort::kThorough);

/// How deep two solids overlap: the shortest way that parts them, m, from above; 0 if they do not overlap.
[[nodiscard]] double depth(const Convex& a, const Convex& b, const Eigen::Isometry3d& X_AB);

}  // namespace takt::collision
