#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "core/kinematics/chain.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// Where an arm that cannot turn its tool freely comes nearest to a pose.
struct NearestPlace {
  JointVector q;      ///< inside the limits, rad or m
  double turn = 0.0;  ///< between the tool's orientation there and the one that was wanted, rad, [0, pi]
};

/// For chains of fewer than six joints: joint positions in which the origin of the tool frame M = F * X_FM is at its
/// place (to 1e-9 m) and turned away from the pose as little as joints near the reference allow. Newton's method on
/// both, in which the place counts a thousand times as much; where it ends elsewhere, from other beginnings inside the
/// limits, and the one with the least turn is taken.
/// @return nothing if the place is out of reach. Realtime: setup, deterministic.
[[nodiscard]] std::optional<NearestPlace> nearest_place(const Chain& chain, const Eigen::Isometry3d& X_BM,
                                                        const Eigen::Isometry3d& X_FM, const JointVector& reference);

}  // namespace takt::kinematics
