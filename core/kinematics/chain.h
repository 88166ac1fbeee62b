#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/kinematics/robot_model.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// A rigid body fixed to the flange: tool and payload as the controller knows them.
struct Payload {
  double mass = 0.0;                               ///< kg, >= 0
  Eigen::Vector3d p_FC = Eigen::Vector3d::Zero();  ///< centre of mass in flange frame F, m
  Eigen::Matrix3d I_C = Eigen::Matrix3d::Zero();   ///< inertia about the centre of mass, axes of F, kg m^2
};

/// Mass, first moment and inertia of a rigid body about the origin of some frame, in its axes: bodies joined rigidly
/// add up.
struct SpatialInertia {
  double mass = 0.0;                            ///< kg
  Eigen::Vector3d h = Eigen::Vector3d::Zero();  ///< mass times centre of mass, kg m
  Eigen::Matrix3d I = Eigen::Matrix3d::Zero();  ///< about the origin, kg m^2

  /// A body given about its centre of mass: pose X of frame C in the wanted frame. Realtime: cyclic.
  [[nodiscard]] static SpatialInertia at(double mass, const Eigen::Isometry3d& X, const Eigen::Matrix3d& I_C);
  SpatialInertia& operator+=(const SpatialInertia& other);
};

/// The movable joints from a base link to a flange link of a robot, flattened for the cycle: fixed joints and the
/// bodies behind them are merged at construction. Immutable and thread-safe: all functions are const.
/// Frames: B = base link, F = flange link. Joint order = from the base outwards.
class Chain {
 public:
  /// What lies above the base link is left out; all below it belongs to the chain.
  /// @param rolling  joints beside the path whose bodies turn without changing where mass lies (the wheels of a base):
  /// they are merged as they stand at zero
  /// @return the chain, or all diagnostics: unknown link, no path, no movable joint, more than kMaxJoints, any other
  /// movable joint on a branch beside the path (its bodies could not be merged). Realtime: setup.
  [[nodiscard]] static Result<Chain> create(const RobotModel& model, const std::string& base_link,
                                            const std::string& flange_link, std::span<const std::string> rolling = {});

  [[nodiscard]] int joint_count() const { return count_; }
  [[nodiscard]] const std::vector<std::string>& joint_names() const { return names_; }
  /// Limits as in the URDF: rad or m; -infinity and +infinity for a continuous joint.
  [[nodiscard]] const JointVector& lower() const { return lower_; }
  [[nodiscard]] const JointVector& upper() const { return upper_; }
  /// rad/s or m/s, and Nm or N; +infinity where the URDF of a continuous joint gives none.
  [[nodiscard]] const JointVector& velocity_limit() const { return velocity_limit_; }
  [[nodiscard]] const JointVector& effort_limit() const { return effort_limit_; }
  /// Viscous damping, Nms/rad or Ns/m, and Coulomb friction, Nm or N, as in the URDF. Not part of inverse_dynamics.
  [[nodiscard]] const JointVector& damping() const { return damping_; }
  [[nodiscard]] const JointVector& friction() const { return friction_; }
  /// True for a sliding joint, whose unit is m instead of rad.
  [[nodiscard]] bool is_prismatic(int joint) const { return segments_[static_cast<std::size_t>(joint)].prismatic; }
  /// Mass of all bodies from the base link (included) to the tips beyond the flange, kg.
  [[nodiscard]] double total_mass() const { return total_mass_; }
  /// Sum of the distances between consecutive joints and on to the flange: no point of F is further than this from the
  /// first joint while prismatic joints are at zero, m. Without the way from B to the first joint.
  [[nodiscard]] double reach() const { return reach_; }

  // All below: q, dq, ddq have joint_count() entries (a precondition). Realtime: cyclic, O(n), no allocation.

  /// X_BF, translation in m.
  [[nodiscard]] Eigen::Isometry3d forward(const JointVector& q) const;
  /// Pose of the flange and geometric Jacobian of F expressed in B: [v_BF_B; w_BF_B] = J dq; J is resized to 6 x n.
  void jacobian(const JointVector& q, Eigen::Isometry3d& X_BF, Jacobian& J) const;
  /// The velocity-product term Jdot(q, dq) dq, linear first, expressed in B, m/s^2 and rad/s^2.
  [[nodiscard]] Vector6 jacobian_dot_times_dq(const JointVector& q, const JointVector& dq) const;
  /// Joint torques (Nm or N) for a motion: M(q) ddq + C(q, dq) dq + g(q), payload included. Gravity is expressed in B,
  /// m/s^2, e.g. (0, 0, -9.81) for an arm on the floor. Source: Luh, Walker, Paul 1980 (recursive Newton-Euler).
  [[nodiscard]] JointVector inverse_dynamics(const JointVector& q, const JointVector& dq, const JointVector& ddq,
                                             const Eigen::Vector3d& gravity_B, const Payload& payload = {}) const;
  /// What tau = M q' s'' + (M q'' + C(q, q') q') s'^2 + g is made of along a path q(s), whatever its law: Nm or N.
  struct PathDynamics {
    JointVector inertial;     ///< M q'
    JointVector centrifugal;  ///< M q'' + C(q, q') q'
    JointVector gravity;      ///< g
  };
  /// The same numbers as three times inverse_dynamics(), in half the time: the three share the chain at q, and what
  /// does not turn needs no products of velocities. @param first, second  q' and q''
  [[nodiscard]] PathDynamics path_dynamics(const JointVector& q, const JointVector& first, const JointVector& second,
                                           const Eigen::Vector3d& gravity_B, const Payload& payload = {}) const;
  /// Joint-space inertia M(q), n x n, symmetric, payload included; kg m^2, kg m, kg.
  /// Source: Walker, Orin 1982 (composite rigid bodies).
  [[nodiscard]] JointMatrix mass_matrix(const JointVector& q, const Payload& payload = {}) const;

 private:
  /// A joint with the body that it moves. Its frame is turned at construction so that the axis is local z: a rotation
  /// by q then mixes two columns only.
  struct Segment {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< of this frame at q = 0 in the previous one
    Eigen::Vector3d p = Eigen::Vector3d::Zero();      ///< origin in the previous frame, m
    bool prismatic = false;
    SpatialInertia body;  ///< all bodies fixed to this frame
  };
  using Bodies = std::array<SpatialInertia, kMaxJoints>;
  using Rotations = std::array<Eigen::Matrix3d, kMaxJoints>;
  using Vectors = std::array<Eigen::Vector3d, kMaxJoints>;
  /// Axes and origin of a frame in B as columns of four, which the processor adds in pairs; w = 0, 0, 0, 1.
  struct Columns {
    Eigen::Vector4d x, y, z, p;
  };
  friend struct ChainBuilder;
  friend class InverseKinematics;

  [[nodiscard]] const Segment& segment(int i) const { return segments_[static_cast<std::size_t>(i)]; }
  /// Goes from B to F and shows visit(i, columns) each joint's frame before its rotation or shift by q.
  template <class Visit>
  [[nodiscard]] Eigen::Isometry3d walk(const JointVector& q, Visit visit) const;
  /// jacobian() for a J of the right size.
  void fill(const JointVector& q, Eigen::Isometry3d& X_BF, Jacobian& J) const;
  /// jacobian_dot_times_dq() from the Jacobian.
  [[nodiscard]] Vector6 bias(const Jacobian& J, const JointVector& dq) const;
  /// Rotation and origin of each joint frame in the previous one at q.
  void relative(const JointVector& q, Rotations& R, Vectors& p) const;
  [[nodiscard]] SpatialInertia payload_body(const Payload& payload) const;
  /// The chain at one q with its payload.
  struct KinematicState {
    Rotations R;
    Vectors p;
    SpatialInertia last_body;  ///< of the last joint, payload included
  };
  [[nodiscard]] KinematicState stance(const JointVector& q, const Payload& payload) const;
  /// What moves: nothing, or accelerations only, or velocities too. What stands still is taken to be zero.
  enum class Moving { kNothing, kFromRest, kAll };
  template <Moving kMoving>
  [[nodiscard]] JointVector newton_euler(const KinematicState& at, const JointVector& dq, const JointVector& ddq,
                                         const Eigen::Vector3d& gravity_B) const;

  int count_ = 0;
  std::array<Segment, kMaxJoints> segments_;
  Eigen::Isometry3d X_LF_ = Eigen::Isometry3d::Identity();  ///< flange in the last joint frame
  double total_mass_ = 0.0;
  double reach_ = 0.0;
  std::vector<std::string> names_;
  JointVector lower_, upper_, velocity_limit_, effort_limit_, damping_, friction_;
};

}  // namespace takt::kinematics
