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
  /// Which joint of a seven-axis chain is held while the others are solved for; -1: redundant_joint().
  int held_joint = -1;
  /// Values of the held joint at which a seven-axis chain is solved, rad or m; empty: the reference's and a grid over
  /// the joint's limits, and any value where these find nothing. Other chains have no held joint here.
  std::vector<double> held_values;
  /// The other redundancy coordinate, for S-R-S arms: arm angles (arm_angle.h), rad, at which the chain is solved
  /// instead of holding a joint. Where the chain is no S-R-S arm, or the angle is undefined at the pose, there are no
  /// solutions.
  std::vector<double> arm_angles;
  /// Closed forms (closed_form.h) and elimination (elimination.h) are used where the chain's geometry allows; false:
  /// the numeric search in any case, which takes a thousand times longer and may miss a branch.
  bool closed_form = true;
  /// True: the turns of a joint by 2 pi that fit its limits are solutions of their own. False: each branch once, every
  /// joint in the turn that is nearest to the reference inside the limits.
  bool turns = true;
  /// No more than this many are returned: the nearest of those found.
  int most = 256;
  /// The search ends once it has found this many: 1 answers whether the pose can be reached.
  int enough = 256;
};

/// The joint of a seven-axis chain whose value leaves six that have a closed form: the third where that does (LWR,
/// iiwa), else the first that does, from the flange inwards; the third where none does.
[[nodiscard]] int redundant_joint(const Chain& chain);

/// `count` arm angles evenly over the circle, rad.
[[nodiscard]] std::vector<double> arm_angle_grid(int count);

/// All distinct joint positions inside the limits that put the flange there. Six revolute joints: in closed form for
/// most arms, by elimination for any other geometry. Sliding joints: by a deterministic search. Each solution is
/// polished to 1e-12 and checked by forward kinematics to 1e-9 m and rad. Where a chain has more than six joints, and
/// in a singular posture (posture.h says so), the solutions are a sample of infinitely many.
/// @return sorted by distance to the reference; empty if the pose is out of reach. Realtime: setup.
[[nodiscard]] std::vector<JointVector> inverse_solutions(const Chain& chain, const Eigen::Isometry3d& X_BF,
                                                         const SolutionOptions& options = {});

}  // namespace takt::kinematics
