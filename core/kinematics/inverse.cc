#include "core/kinematics/inverse.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "core/kinematics/lu6.h"
#include "core/kinematics/pose_error.h"

namespace takt::kinematics {
namespace {

using Matrix6 = Lu6::Matrix6;

/// Most that one joint moves in one step of Newton's method, rad or m: the linear picture is good no further.
constexpr double kMaxStep = 0.25;

/// What a step leaves behind is at most half its square (sum over the joints, lengths in units of the reach), so after
/// one as small as this the residual need not be looked at: 8e-14.
constexpr double kLastStep = 4e-7;
/// The same where the Jacobian is used on: it changes by no more than the step itself.
constexpr double kLastStepOfMotion = 1e-12;

/// The step of Levenberg and Marquardt. The damping shrinks with the residual, so that convergence stays quadratic.
/// Source: Yamashita, Fukushima 2001.
Vector6 damped_step(const Matrix6& A, const Vector6& error) {
  const double lambda = std::min(InverseKinematics::kDampedBelow, error.norm());
  Matrix6 normal = A.transpose().lazyProduct(A);
  normal.diagonal().array() += lambda * lambda + 1e-30;
  const Vector6 right = A.transpose().lazyProduct(error);
  return normal.llt().solve(right);
}

/// Fills the columns from `count` on with unit vectors, square to each other, in directions that the columns before do
/// not span: what the joints of a short chain cannot do. Gram and Schmidt, on the axis that is left over most.
void fill_up(Matrix6& A, int count) {
  Matrix6 basis = Matrix6::Zero();
  const auto remainder = [&](Vector6 v, int columns) {
    for (int k = 0; k < columns; ++k) v -= basis.col(k).dot(v) * basis.col(k);
    return v;
  };
  for (int k = 0; k < count; ++k) {
    const Vector6 own = remainder(A.col(k), k);
    const double length = own.norm();
    if (length > 1e-12 * A.col(k).norm()) basis.col(k) = own / length;  // else singular: the pivots tell
  }
  for (int k = count; k < 6; ++k) {
    Vector6 most = Vector6::Zero();
    for (int axis = 0; axis < 6; ++axis) {
      const Vector6 left = remainder(Vector6::Unit(axis), k);
      if (left.squaredNorm() > most.squaredNorm()) most = left;
    }
    basis.col(k) = most.normalized();
    A.col(k) = basis.col(k);
  }
}

Findings check_held(int joint_count, const std::vector<int>& held) {
  Findings findings;
  const int wanted = std::max(0, joint_count - 6);
  if (static_cast<int>(held.size()) != wanted)
    findings.error({}, fmt::format("{} held joints for a chain of {}", held.size(), joint_count),
                   wanted > 0 ? fmt::format("{}, so that six remain", wanted) : "none");
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i] < 0 || held[i] >= joint_count)
      findings.error(pointer_segment(i), fmt::format("held joint {}", held[i]),
                     fmt::format("0 to {}", joint_count - 1));
    if (std::find(held.begin(), held.begin() + static_cast<std::ptrdiff_t>(i), held[i]) !=
        held.begin() + static_cast<std::ptrdiff_t>(i))
      findings.error(pointer_segment(i), fmt::format("joint {} is held twice", held[i]));
  }
  return findings;
}

}  // namespace

const char* to_string(IkStatus status) {
  switch (status) {
    case IkStatus::kOk:
      return "ok";
    case IkStatus::kNotConverged:
      return "not converged";
    case IkStatus::kSingular:
      return "singular";
  }
  return "unknown";
}

struct InverseKinematics::Linear {
  Eigen::Isometry3d X_BF;
  Jacobian J;  ///< of all joints
  Matrix6 A;   ///< columns of the free joints, rows weighted
  Lu6 lu;
  double pivot = 0.0;
  bool linearised = false;
};

Result<InverseKinematics> InverseKinematics::create(const Chain& chain, std::vector<int> held_joints) {
  Findings findings = check_held(chain.joint_count(), held_joints);
  if (findings.has_errors()) return std::unexpected(std::move(findings));
  InverseKinematics inverse(chain);
  inverse.held_joints_ = std::move(held_joints);
  std::size_t k = 0;
  for (int i = 0; i < chain.joint_count(); ++i) {
    const auto& held = inverse.held_joints_;
    if (std::find(held.begin(), held.end(), i) == held.end()) inverse.free_joints_[k++] = i;
  }
  inverse.free_count_ = static_cast<int>(k);
  inverse.length_scale_ = std::max(chain.reach(), 1e-3);
  inverse.tolerance_ = 1e-12 * std::max(1.0, chain.reach());
  return inverse;
}

Result<InverseKinematics> InverseKinematics::create(const Chain& chain) {
  if (chain.joint_count() == 7) return create(chain, {2});
  if (chain.joint_count() > 7)
    return failure({}, fmt::format("a chain of {} joints has no default held joints", chain.joint_count()),
                   fmt::format("name {}", chain.joint_count() - 6));
  return create(chain, {});
}

JointVector InverseKinematics::held(const JointVector& q) const {
  JointVector values(static_cast<Eigen::Index>(held_joints_.size()));
  for (std::size_t i = 0; i < held_joints_.size(); ++i) values[static_cast<Eigen::Index>(i)] = q[held_joints_[i]];
  return values;
}

Vector6 InverseKinematics::weighted(const Vector6& v) const {
  Vector6 result = v;
  result.head<3>() *= 1.0 / length_scale_;
  return result;
}

void InverseKinematics::linearise(Linear& at) const {
  const double weight = 1.0 / length_scale_;
  for (int k = 0; k < free_count_; ++k) {
    at.A.col(k) = at.J.col(free_joints_[static_cast<std::size_t>(k)]);
    at.A.col(k).head<3>() *= weight;
  }
  if (free_count_ < 6) fill_up(at.A, free_count_);
  at.pivot = at.lu.factor(at.A);
  at.linearised = true;
}

IkStatus InverseKinematics::converge(const Eigen::Isometry3d& X_BF, const JointVector& held, double last_step,
                                     JointVector& q, Linear& at) const {
  for (std::size_t i = 0; i < held_joints_.size(); ++i) q[held_joints_[i]] = held[static_cast<Eigen::Index>(i)];
  const JointVector seed = q;
  for (int step = 0; step < kMaxSteps; ++step) {
    chain_.jacobian(q, at.X_BF, at.J);
    at.linearised = false;
    const Vector6 error = pose_error(at.X_BF, X_BF);
    const double p_error = error.head<3>().cwiseAbs().maxCoeff();
    const double r_error = error.tail<3>().cwiseAbs().maxCoeff();
    if (p_error <= tolerance_ && r_error <= 1e-12) return IkStatus::kOk;

    linearise(at);
    const Vector6 e = weighted(error);
    const bool damped = !(at.pivot > kDampedBelow);
    Vector6 delta = damped ? damped_step(at.A, e) : at.lu.solve(e);
    const double longest = delta.cwiseAbs().maxCoeff();
    if (longest > kMaxStep) delta *= kMaxStep / longest;
    double travel = 0.0;
    for (int k = 0; k < free_count_; ++k) {
      const int joint = free_joints_[static_cast<std::size_t>(k)];
      q[joint] += delta[k];
      travel = std::max(travel, std::abs(q[joint] - seed[joint]));
    }
    if (!damped && delta.cwiseAbs().sum() <= last_step) return IkStatus::kOk;
    // Written so that NaN ends here too.
    if (!(longest < std::numeric_limits<double>::infinity()) || travel > kMaxTravel) break;
  }
  return IkStatus::kNotConverged;
}

IkStatus InverseKinematics::solve(const Eigen::Isometry3d& X_BF, const JointVector& held, JointVector& q) const {
  Linear at;
  JointVector solution = q;
  const IkStatus status = converge(X_BF, held, kLastStep, solution, at);
  if (status == IkStatus::kOk) q = solution;
  return status;
}

JointVector InverseKinematics::solve_linear(const Linear& at, const Vector6& y, const JointVector& held) const {
  JointVector x(chain_.joint_count());
  Vector6 rest = y;
  for (std::size_t i = 0; i < held_joints_.size(); ++i) {
    const double value = held[static_cast<Eigen::Index>(i)];
    x[held_joints_[i]] = value;
    rest -= at.J.col(held_joints_[i]) * value;
  }
  const Vector6 free = at.lu.solve(weighted(rest));
  for (int k = 0; k < free_count_; ++k) x[free_joints_[static_cast<std::size_t>(k)]] = free[k];
  return x;
}

IkStatus InverseKinematics::rates(const JointVector& q, const Vector6& V_BF_B, const JointVector& held_dq,
                                  JointVector& dq) const {
  Linear at;
  chain_.jacobian(q, at.X_BF, at.J);
  linearise(at);
  if (!(at.pivot > kSingularBelow)) return IkStatus::kSingular;
  dq = solve_linear(at, V_BF_B, held_dq);
  return IkStatus::kOk;
}

IkStatus InverseKinematics::accelerations(const JointVector& q, const JointVector& dq, const Vector6& A_BF_B,
                                          const JointVector& held_ddq, JointVector& ddq) const {
  Linear at;
  chain_.jacobian(q, at.X_BF, at.J);
  linearise(at);
  if (!(at.pivot > kSingularBelow)) return IkStatus::kSingular;
  ddq = solve_linear(at, A_BF_B - chain_.bias(at.J, dq), held_ddq);
  return IkStatus::kOk;
}

IkStatus InverseKinematics::solve_motion(const Goal& goal, JointVector& q, JointVector& dq, JointVector& ddq) const {
  Linear at;
  JointVector solution = q;
  const IkStatus status = converge(goal.X_BF, goal.held, kLastStepOfMotion, solution, at);
  if (status != IkStatus::kOk) return status;
  if (!at.linearised) linearise(at);
  if (!(at.pivot > kSingularBelow)) return IkStatus::kSingular;
  q = solution;
  dq = solve_linear(at, goal.V_BF_B, goal.held_dq);
  ddq = solve_linear(at, goal.A_BF_B - chain_.bias(at.J, dq), goal.held_ddq);
  return IkStatus::kOk;
}

Vector6 InverseKinematics::beyond_joints(const JointVector& q, const Eigen::Isometry3d& X_BF) const {
  Linear at;
  chain_.jacobian(q, at.X_BF, at.J);
  linearise(at);
  Vector6 beyond = Vector6::Zero();
  if (!(at.pivot > kSingularBelow)) return beyond;
  const Vector6 free = at.lu.solve(weighted(pose_error(at.X_BF, X_BF)));
  for (int k = free_count_; k < 6; ++k) beyond += free[k] * at.A.col(k);
  beyond.head<3>() *= length_scale_;
  return beyond;
}

double InverseKinematics::singularity_measure(const JointVector& q) const {
  Linear at;
  chain_.jacobian(q, at.X_BF, at.J);
  linearise(at);
  return Eigen::JacobiSVD<Matrix6>(at.A).singularValues()[5];
}

double limit_distance(const Chain& chain, const JointVector& q) {
  double distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < chain.joint_count(); ++i)
    distance = std::min({distance, q[i] - chain.lower()[i], chain.upper()[i] - q[i]});
  return distance;
}

}  // namespace takt::kinematics
