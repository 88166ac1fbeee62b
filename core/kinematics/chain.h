#pragma once

#include <string>
#include <vector>

#include "core/base/findings.h"
#include "core/kinematics/robot_model.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// A rigid body fixed to the flange: tool and payload as the controller knows them.
struct Payload {
  double mass = 0.0;                               ///< kg, >= 0
  Eigen::Vector3d p_FC = Eigen::Vector3d::Zero();  ///< centre of mass in flange frame F, m
  Eigen::Matrix3d I_C = Eigen::Matrix3d::Zero();   ///< inertia about the centre of mass, axes of F, kg m^2
};

/// The movable joints from a base link to a flange link of a robot, flattened for the cycle: fixed joints and the
/// bodies behind them are merged at construction. Immutable but for nothing: all functions are const and thread-safe.
/// Frames: B = base link, F = flange link. Joint order = from the base outwards.
class Chain {
 public:
  /// @return the chain, or findings: unknown link, no path, no movable joint, more than kMaxJoints, a joint type other
  /// than revolute, continuous or prismatic. Realtime: setup.
  [[nodiscard]] static Result<Chain> create(const RobotModel& model, const std::string& base_link,
                                            const std::string& flange_link);

  [[nodiscard]] int joint_count() const;
  [[nodiscard]] const std::vector<std::string>& joint_names() const;
  /// Limits as in the URDF: rad or m; +-infinity for a continuous joint. [[nodiscard]]
  [[nodiscard]] const JointVector& lower() const;
  [[nodiscard]] const JointVector& upper() const;
  [[nodiscard]] const JointVector& velocity_limit() const;
  [[nodiscard]] const JointVector& effort_limit() const;
  /// Mass of all bodies from the base link (included) to the tips beyond the flange, kg.
  [[nodiscard]] double total_mass() const;

  // All below: q, dq, ddq have joint_count() entries (a precondition). Realtime: cyclic, O(n), no allocation.

  [[nodiscard]] Eigen::Isometry3d forward(const JointVector& q) const;
  /// Pose of the flange and geometric Jacobian of F expressed in B: [v_BF_B; w_BF_B] = J dq.
  void jacobian(const JointVector& q, Eigen::Isometry3d& X_BF, Jacobian& J) const;
  /// The velocity-product term Jdot(q, dq) dq, linear first, expressed in B.
  [[nodiscard]] Vector6 jacobian_dot_times_dq(const JointVector& q, const JointVector& dq) const;
  /// Joint torques (Nm or N) for a motion: M(q) ddq + C(q, dq) dq + g(q), payload included. Gravity is expressed in B,
  /// m/s^2.
  [[nodiscard]] JointVector inverse_dynamics(const JointVector& q, const JointVector& dq, const JointVector& ddq,
                                             const Eigen::Vector3d& gravity_B, const Payload& payload = {}) const;
  /// Joint-space inertia M(q), symmetric, payload included.
  [[nodiscard]] JointMatrix mass_matrix(const JointVector& q, const Payload& payload = {}) const;
};

}  // namespace takt::kinematics
