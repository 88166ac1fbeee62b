#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/kinematics/chain.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// All solutions of six revolute joints in closed form, for the geometries of nearly all arms, recognised from the
/// chain's axes alone. Joints beyond six are held at given values.
///   spherical wrist: the last three axes meet in a point, and of the first three either the first two meet (LWR with
///   its third joint held, iiwa) or the last two are parallel (TX90 and most six-axis arms);
///   three parallel axes: 2, 3 and 4 are parallel, and the last two meet (UR).
/// The decomposition leads to rotations about one axis at a time that carry a point to a point, a plane or a sphere.
/// Source: the subproblems of Paden 1986 and Kahan 1983; own derivation in docs/kinematics.md. Realtime: setup.
class ClosedForm {
 public:
  /// @param q_held  joint values of which those of the held joints matter   @param held  n-6 indices
  /// @return nothing if the chain is not of a known geometry.
  [[nodiscard]] static std::optional<ClosedForm> recognise(const Chain& chain, const JointVector& q_held,
                                                           const std::vector<int>& held);

  /// At most eight candidates, angles in (-pi, pi], held joints at their values. Correct to about 1e-8 near singular
  /// poses, to rounding elsewhere: whoever uses them polishes and checks. Limits are not looked at.
  [[nodiscard]] std::vector<JointVector> solve(const Eigen::Isometry3d& X_BF) const;

 private:
  enum class Family { kWristAxesMeet, kWristAxesParallel, kThreeParallel };
  using Angles = std::array<double, 6>;

  [[nodiscard]] std::optional<Family> family();
  [[nodiscard]] const Eigen::Vector3d& axis(int i) const { return axes_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Eigen::Vector3d& point(int i) const { return points_[static_cast<std::size_t>(i)]; }
  void solve_shoulder_first(const Eigen::Isometry3d& T, std::vector<Angles>& found) const;
  void solve_elbow_first(const Eigen::Isometry3d& T, std::vector<Angles>& found) const;
  void solve_three_parallel(const Eigen::Isometry3d& T, std::vector<Angles>& found) const;
  void solve_wrist(const Eigen::Isometry3d& T, Angles angles, std::vector<Angles>& found) const;

  Family family_ = Family::kWristAxesMeet;
  // All at zero of the free joints, in B: a direction and a point of each axis.
  std::array<Eigen::Vector3d, 6> axes_;
  std::array<Eigen::Vector3d, 6> points_;
  std::array<int, 6> free_{};
  Eigen::Isometry3d X_BF_zero_ = Eigen::Isometry3d::Identity();
  Eigen::Vector3d wrist_ = Eigen::Vector3d::Zero();     ///< where the last three (UR: two) axes meet
  Eigen::Vector3d shoulder_ = Eigen::Vector3d::Zero();  ///< where the first two meet
  JointVector q_held_;
};

}  // namespace takt::kinematics
