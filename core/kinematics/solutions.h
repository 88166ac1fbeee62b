#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "core/kinematics/chain.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// What inverse_solutions looks for.
struct SolutionOptions {
  /// Solutions are sorted by their distance to it (2-norm), and it is the first seed; size 0: the middle of the limits.
  JointVector reference;
  /// Values of the held joint (the third) at which a seven-axis chain is solved, rad or m; empty: the reference's and a
  /// grid over the joint's limits, and any value where these find nothing. Other chains have no held joint here.
  std::vector<double> held_values;
  /// Closed forms (closed_form.h) are used where the chain's geometry allows; false: the numeric search in any case,
  /// which takes a thousand times longer and may miss a branch.
  bool closed_form = true;
  /// No more than this many are returned: the nearest of those found.
  int most = 256;
  /// The search ends once it has found this many: 1 answers whether the pose can be reached.
  int enough = 256;
};

/// All distinct joint positions inside the limits that put the flange there: in closed form for most arms, else by a
/// deterministic search; each solution polished to 1e-12 and checked by forward kinematics to 1e-9 m and rad. Turns of
/// a joint by 2 pi that fit its limits count as solutions of their own. Where a chain has more than six joints the
/// solutions are a sample of infinitely many. @return sorted by distance to the reference; empty if the pose is out of
/// reach. Realtime: setup.
[[nodiscard]] std::vector<JointVector> inverse_solutions(const Chain& chain, const Eigen::Isometry3d& X_BF,
                                                         const SolutionOptions& options = {});

}  // namespace takt::kinematics
