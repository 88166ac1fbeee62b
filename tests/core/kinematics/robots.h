#pragma once

#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/robot_model.h"

namespace takt::kinematics::test {

/// The KUKA LWR 4+ with published lengths, limits and masses; round inertias. Links base, link_1..link_7, flange.
[[nodiscard]] std::string lwr_urdf();
/// Universal Robots UR5 and Staubli TX90, kinematics only in the sense that each link is a round body.
[[nodiscard]] std::string ur5_urdf();
[[nodiscard]] std::string tx90_urdf();

/// Arms in the manner of other makers: their lengths are round, what matters is how the axes lie and how files write
/// it.
struct ForeignArm {
  std::string name;
  std::string urdf;  ///< links base .. flange, as above
  std::vector<int> held;
  /// The family of closed forms, as to_string says it; empty: there is none.
  std::string family;
  bool reversed = false;
};
[[nodiscard]] std::vector<ForeignArm> foreign_arms();

/// Parses and builds, or fails the running test and ends the process.
[[nodiscard]] RobotModel model_of(const std::string& urdf);
[[nodiscard]] Chain chain_of(const std::string& urdf);
[[nodiscard]] Chain lwr();

/// A chain with random poses, axes, types, bodies and fixed joints, some of them on side branches.
/// Links l0 .. ln (the path) and side links without joints of their own.
[[nodiscard]] RobotModel random_model(Random& random, int movable_joints);

/// Inside the limits; within +-3 rad or m where there are none.
[[nodiscard]] JointVector random_q(Random& random, const Chain& chain);
[[nodiscard]] JointVector random_vector(Random& random, int size, double bound);
[[nodiscard]] Eigen::Isometry3d random_pose(Random& random, double bound);

/// max(|translation|, |rotation angle|) between two poses, m or rad.
[[nodiscard]] double pose_distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

}  // namespace takt::kinematics::test
