#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "core/kinematics/chain.h"
#include "core/kinematics/cone.h"
#include "core/kinematics/lines.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// What the axes of six revolute joints have in common, and so the way to all solutions of a pose.
enum class ArmFamily {
  kWristShoulderMeets,  ///< spherical wrist, axes 1 and 2 meet (LWR with its third joint held, iiwa)
  kWristElbowParallel,  ///< spherical wrist, axes 2 and 3 parallel (TX90 and most six-axis arms)
  kWristAnyArm,         ///< spherical wrist, any first three axes
  kThreeParallel,       ///< axes 2, 3 and 4 parallel, 5 and 6 meet (UR)
};

/// E.g. "spherical wrist, parallel elbow".
[[nodiscard]] std::string_view to_string(ArmFamily family);

/// All solutions of six revolute joints in closed form, for the geometries of nearly all arms, recognised from the
/// chain's axes alone: names, signs, zero positions and the frames of the links do not matter. Joints beyond six are
/// held at given values. An arm whose *shoulder* is spherical is solved from its other end.
/// The decomposition leads to rotations about one axis at a time that carry a point to a point, a plane or a sphere,
/// and in the family `kWristAnyArm` to one polynomial of degree four.
/// Source: Pieper 1968; the subproblems of Paden 1986 and Kahan 1983; own derivation in docs/kinematics.md.
class ClosedForm {
 public:
  using Angles = std::array<double, 6>;
  /// Angles of the free joints in (-pi, pi], in the order of the chain.
  struct Candidates {
    std::array<Angles, 64> angles;
    int count = 0;
    double margin = kExact;  ///< how far a pose may be out of reach (cone.h) to get guesses beside it
    void add(const Angles& next) {
      if (count < static_cast<int>(angles.size())) angles[static_cast<std::size_t>(count++)] = next;
    }
  };

  /// @param q_held  joint values of which those of the held joints matter   @param held  n-6 indices
  /// @return nothing if the chain is not of a known geometry. Realtime: setup.
  [[nodiscard]] static std::optional<ClosedForm> recognise(const Chain& chain, const JointVector& q_held,
                                                           const std::vector<int>& held);

  /// At most eight candidates in closed form, and more in singular postures of which there is a choice. As good as the
  /// geometry is exact (kAlmost), near singular postures too: whoever uses them polishes and checks. Limits are not
  /// looked at. @param[in,out] found  in: its margin. Realtime: cyclic, bounded, no allocation.
  void solve(const Eigen::Isometry3d& X_BF, Candidates& found) const;
  /// All joints for a candidate, the held ones at their values. Realtime: cyclic.
  [[nodiscard]] JointVector joints(const Angles& angles) const;

  [[nodiscard]] ArmFamily family() const { return family_; }
  /// True where the arm is solved from its flange: the family is then that of the reversed arm.
  [[nodiscard]] bool reversed() const { return reversed_; }

 private:
  [[nodiscard]] bool find_family();
  void reverse();
  [[nodiscard]] const Eigen::Vector3d& axis(int i) const { return lines_[static_cast<std::size_t>(i)].axis; }
  [[nodiscard]] const Eigen::Vector3d& point(int i) const { return lines_[static_cast<std::size_t>(i)].point; }
  void solve_shoulder_first(const Eigen::Isometry3d& T, Candidates& found) const;
  void solve_elbow_first(const Eigen::Isometry3d& T, Candidates& found) const;
  void solve_any_arm(const Eigen::Isometry3d& T, Candidates& found) const;
  void solve_three_parallel(const Eigen::Isometry3d& T, Candidates& found) const;
  /// The same where joint 6 turns about the direction of axes 2 to 4: any angle of it is as good as another, as long as
  /// the arm gets there. A few are tried.
  void solve_free_turn(const Eigen::Isometry3d& T, double q1, double q5, Candidates& found) const;
  /// Where axis 4 of the three-parallel family is to go in the plane across them, from axis 2, and the turn of joints 2
  /// to 4 together.
  struct PlanarGoal {
    Eigen::Matrix3d R;
    Eigen::Vector3d place;
  };
  [[nodiscard]] PlanarGoal planar_goal(const Eigen::Isometry3d& T, double q1, double q5, double q6) const;
  /// Joints 2 to 4 of the three-parallel family, joints 1, 5 and 6 known.
  void solve_planar(const Eigen::Isometry3d& T, double q1, double q5, double q6, Candidates& found) const;
  void solve_wrist(const Eigen::Isometry3d& T, double q1, double q2, double q3, Candidates& found) const;

  ArmFamily family_ = ArmFamily::kWristShoulderMeets;
  bool reversed_ = false;
  std::array<Line, 6> lines_;  ///< at zero of the free joints, in B
  std::array<int, 6> free_{};
  Eigen::Isometry3d X_FB_zero_ = Eigen::Isometry3d::Identity();
  Eigen::Vector3d wrist_ = Eigen::Vector3d::Zero();     ///< where the last three (UR: two) axes meet
  Eigen::Vector3d shoulder_ = Eigen::Vector3d::Zero();  ///< where the first two meet
  JointVector q_held_;
};

}  // namespace takt::kinematics
