#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "core/kinematics/chain.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// What inverse_solutions looks for.
struct SolutionOptions {
  /// Solutions are sorted by their distance to it (2-norm), and it is a seed; size 0: the middle of the limits.
  JointVector reference;
  /// Values of the held joint (the third) at which a seven-axis chain is solved; empty: the reference's value and a
  /// grid over the joint's limits. Each chain of more than seven axes is solved with all joints free.
  std::vector<double> held_values;
  /// No more than this many are returned: the nearest.
  int most = 256;
};

/// All distinct joint positions inside the limits that put the flange there: a deterministic search, each solution
/// polished to 1e-12 and checked by forward kinematics to 1e-9 m and rad. Turns by 2 pi of a joint that fit its limits
/// count as solutions of their own. @return sorted by distance to the reference; empty if the pose is out of reach.
/// Realtime: setup.
[[nodiscard]] std::vector<JointVector> inverse_solutions(const Chain& chain, const Eigen::Isometry3d& X_BF,
                                                         const SolutionOptions& options = {});

}  // namespace takt::kinematics
