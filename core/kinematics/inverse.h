#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/base/diagnostics.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

enum class IkStatus {
  kOk,
  kNotConverged,  ///< no solution on this branch: out of reach, or the seed is too far away
  kSingular,      ///< at the solution the Jacobian is singular: rates and accelerations do not exist
};

[[nodiscard]] const char* to_string(IkStatus status);

/// Inverse kinematics in the cycle, on one branch: Newton's method from a seed near the solution.
/// A chain of n > 6 joints keeps n-6 *held* joints at given values: the redundancy is a coordinate of the path like the
/// pose itself, so the same point of a path always has the same q; pause, backwards and cancel stay exact.
/// A chain of n < 6 joints cannot turn its flange freely. It is solved where it can do what is asked: the flange's
/// place as exactly as with six, its turn to kTurnSlack; what is between is divided by least squares.
/// Joint limits are not looked at: the planner and the guard do that (see limit_distance).
/// Immutable after creation; thread: any. Holds its own copy of the chain.
class InverseKinematics {
 public:
  /// @param held_joints  n-6 different indices into the joints of the chain, in the order in which values are given;
  /// none for n <= 6   @return diagnostics if the chain has fewer than three joints, or the indices do not fit.
  /// Realtime: setup.
  [[nodiscard]] static Result<InverseKinematics> create(const Chain& chain, std::vector<int> held_joints);
  /// The held joint that is right for most arms: none for n <= 6, the third for n == 7; diagnostics for any other n.
  [[nodiscard]] static Result<InverseKinematics> create(const Chain& chain);

  [[nodiscard]] const Chain& chain() const { return chain_; }
  [[nodiscard]] const std::vector<int>& held_joints() const { return held_joints_; }
  /// The held joints' part of q.
  [[nodiscard]] JointVector held(const JointVector& q) const;

  // All below: realtime: cyclic, bounded, no allocation. Sizes are preconditions: q, dq, ddq n; held* n-6, or none.

  /// Joint positions for a flange pose F in B.
  /// Converges quadratically to a residual of 1e-12 m and rad (relative to the arm's size where that is above 1 m), in
  /// at most kMaxSteps steps; near singularities the steps are damped. @param held values of the held joints, rad or m
  /// @param[in,out] q  in: the seed; out: the solution on the seed's branch; untouched unless kOk. No joint moves more
  /// than kMaxTravel from the seed. @return kOk or kNotConverged.
  [[nodiscard]] IkStatus solve(const Eigen::Isometry3d& X_BF, const JointVector& held, JointVector& q) const;

  /// Joint velocities for a flange twist at q; exact, not damped; with fewer than six joints what comes nearest to it.
  /// @param V_BF_B  linear first, m/s and rad/s, expressed in B   @param held_dq  rad/s or m/s
  /// @param[out] dq untouched unless kOk. @return kOk or kSingular.
  [[nodiscard]] IkStatus rates(const JointVector& q, const Vector6& V_BF_B, const JointVector& held_dq,
                               JointVector& dq) const;
  /// Joint accelerations for the time derivative of the flange twist; else like rates().
  [[nodiscard]] IkStatus accelerations(const JointVector& q, const JointVector& dq, const Vector6& A_BF_B,
                                       const JointVector& held_ddq, JointVector& ddq) const;

  /// What the cycle asks for: solve(), rates() and accelerations() with one factorisation.
  struct Goal {
    Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
    Vector6 V_BF_B = Vector6::Zero();  ///< linear first, m/s and rad/s, expressed in B
    Vector6 A_BF_B = Vector6::Zero();  ///< its time derivative
    JointVector held, held_dq, held_ddq;
  };
  /// @param[in,out] q, dq, ddq  q in: the seed; out: the motion; all untouched unless kOk. A good seed is the last
  /// cycle's q extrapolated by its dq and ddq.
  [[nodiscard]] IkStatus solve_motion(const Goal& goal, JointVector& q, JointVector& dq, JointVector& ddq) const;

  /// The derivatives with which the arm passes a q that solves a goal.
  struct Passage {
    JointVector dq, ddq;
    bool regular = false;  ///< singularity_measure(q) is at least what was asked for
  };
  /// rates(), accelerations() and the question for singularity_measure() with one Jacobian: the same numbers, and for
  /// the measure no singular values, unless it is next to `least_measure`. For walks along paths, which ask all three
  /// at each place. @param goal  its X_BF and held are not looked at   @param[out] passage  untouched unless kOk
  /// @return kOk or kSingular.
  [[nodiscard]] IkStatus pass(const JointVector& q, const Goal& goal, double least_measure, Passage& passage) const;

  /// Of the way from the flange at q to X_BF what the joints cannot do at q: translation, m, and rotation vector, rad,
  /// in the axes of B. Zero for chains of six joints and more, and where they are singular.
  [[nodiscard]] Vector6 beyond_joints(const JointVector& q, const Eigen::Isometry3d& X_BF) const;

  /// How far from singular: the smallest singular value of the 6 x 6 Jacobian of the free joints, its linear rows
  /// divided by length_scale(); with fewer than six joints that of all their columns. 0 = singular; the LWR in a good
  /// posture has about 0.3. Realtime: cyclic, O(1).
  [[nodiscard]] double singularity_measure(const JointVector& q) const;
  /// What the linear rows are divided by: the sum of the link lengths, at least 1e-3 m.
  [[nodiscard]] double length_scale() const { return length_scale_; }

  /// No joint moves further than this from the seed in one solve, rad or m: beyond it another branch is near.
  static constexpr double kMaxTravel = 0.5;
  static constexpr int kMaxSteps = 32;
  /// rad: by how much a flange on fewer than six joints may be turned away from what is asked. Files round their
  /// angles to some 1e-4.
  static constexpr double kTurnSlack = 1e-3;
  /// Below this pivot of the weighted Jacobian the steps are damped; see docs/kinematics.md.
  static constexpr double kDampedBelow = 1e-3;
  /// Below this pivot rates do not exist.
  static constexpr double kSingularBelow = 1e-6;

 private:
  explicit InverseKinematics(const Chain& chain) : chain_(chain) {}

  /// The chain at one q, linearised for the free joints.
  struct Linear;

  /// Newton's method from q. It ends when the residual is small enough, or with an undamped step of at most `last_step`
  /// (sum over the joints). `at` is where that step began, or the solution itself and then not linearised.
  [[nodiscard]] IkStatus converge(const Eigen::Isometry3d& X_BF, const JointVector& held, double last_step,
                                  JointVector& q, Linear& at) const;
  void linearise(Linear& at) const;
  /// The free joints' part of J x = y, with the held joints' part of x given; all of x is returned.
  [[nodiscard]] JointVector solve_linear(const Linear& at, const Vector6& y, const JointVector& held) const;
  /// Linear rows divided by the length scale.
  [[nodiscard]] Vector6 weighted(const Vector6& v) const;
  [[nodiscard]] bool is_short() const { return free_count_ < 6; }
  /// x of A x = y: exact with six free joints, with fewer the least squares in which places count far more than turns.
  [[nodiscard]] Vector6 solve_free(const Linear& at, const Vector6& y) const;
  [[nodiscard]] bool is_met(const Vector6& error) const;
  [[nodiscard]] double smallest_singular_value(const Linear& at) const;
  [[nodiscard]] bool is_regular(const Linear& at, double least) const;

  Chain chain_;
  std::vector<int> held_joints_;
  std::array<int, 6> free_joints_{};
  int free_count_ = 6;
  double length_scale_ = 1.0;
  double tolerance_ = 1e-12;
};

/// The smallest distance to a limit over all joints, rad or m; negative outside; +infinity without limits.
/// Realtime: cyclic.
[[nodiscard]] double limit_distance(const Chain& chain, const JointVector& q);

}  // namespace takt::kinematics
