#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/kinematics/chain.h"
#include "core/kinematics/lines.h"

namespace takt::kinematics {

/// Seven revolute joints with a spherical shoulder S (axes 1, 2, 3), an elbow (axis 4) and a spherical wrist W (axes 5,
/// 6, 7), as people have them: S-R-S. While the flange stands, the elbow can swivel on a circle about the line S-W. The
/// *arm angle* says where on that circle it is: the angle about S-W (positive as seen along it, right hand) from the
/// half plane that contains the direction of axis 1 to the one that contains the elbow, in (-pi, pi]. The elbow E is
/// the point of axis 4 that is nearest to S.
/// Undefined where S-W is in line with axis 1, and where the arm is stretched.
class ArmAngle {
 public:
  /// @return nothing if the chain is no S-R-S arm. Realtime: setup.
  [[nodiscard]] static std::optional<ArmAngle> recognise(const Chain& chain);

  /// rad; nothing where it is undefined (the sine of an angle below 1e-6). Realtime: cyclic.
  [[nodiscard]] std::optional<double> of(const JointVector& q) const;

  /// All joint positions, at most eight, with that flange pose and arm angle (rad): two elbows times two shoulders
  /// times two wrists, angles in [-pi, pi], good to rounding outside of singular postures. Limits are not looked at.
  /// Source: Shimizu, Kakuya, Yoon, Kitagaki, Kosuge 2008 (the parameter); own derivation. Realtime: setup.
  [[nodiscard]] std::vector<JointVector> solve(const Eigen::Isometry3d& X_BF, double angle) const;

 private:
  [[nodiscard]] const Line& line(int i) const { return lines_[static_cast<std::size_t>(i)]; }

  const Chain* chain_ = nullptr;
  std::array<Line, kMaxJoints> lines_;  ///< at zero, in B
  Eigen::Isometry3d X_FB_zero_ = Eigen::Isometry3d::Identity();
  Eigen::Vector3d shoulder_ = Eigen::Vector3d::Zero(), wrist_ = Eigen::Vector3d::Zero(),
                  elbow_ = Eigen::Vector3d::Zero();
};

}  // namespace takt::kinematics
