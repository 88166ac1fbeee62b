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
/// The same with fewer than six joints, where what cannot be met lets the steps shrink by a thousandth each.
constexpr double kLastStepOfFewer = 1e-10;

/// Of a turn against a place (in units of the reach), where six equations have fewer unknowns: a turn that is off by
/// 1 mrad then takes the flange a billionth of the reach away from its place.
constexpr double kTurnWeight = 1e-3;

/// A^T A, its lower half only.
Matrix6 gram_of(const Matrix6& A) {
  Matrix6 gram;
  for (int j = 0; j < 6; ++j) {
    for (int i = j; i < 6; ++i) gram(i, j) = A.col(i).dot(A.col(j));
  }
  return gram;
}

/// Of a symmetric matrix that is given by its lower half: whether its Cholesky factors exist.
bool is_positive_definite(Matrix6 M) {
  for (int k = 0; k < 6; ++k) {
    if (!(M(k, k) > 0.0)) return false;
    const double inverse = 1.0 / M(k, k);
    for (int j = k + 1; j < 6; ++j) {
      const double factor = M(j, k) * inverse;
      for (int i = j; i < 6; ++i) M(i, j) -= M(i, k) * factor;
    }
  }
  return true;
}

/// The normal equations of A x = y for the first columns; the others are zero and give zero.
Matrix6 normal_of(const Matrix6& A) {
  Matrix6 normal = A.transpose().lazyProduct(A);
  normal.diagonal().array() += 1e-30;
  return normal;
}

/// The step of Levenberg and Marquardt. The damping shrinks with the residual, so that convergence stays quadratic.
/// Source: Yamashita, Fukushima 2001.
Vector6 damped_step(const Matrix6& A, const Vector6& error) {
  const double lambda = std::min(InverseKinematics::kDampedBelow, error.norm());
  Matrix6 normal = A.transpose().lazyProduct(A);
  normal.diagonal().array() += lambda * lambda + 1e-30;
  const Vector6 right = A.transpose().lazyProduct(error);
  return normal.llt().solve(right);
}

Diagnostics check_held(int joint_count, const std::vector<int>& held) {
  Diagnostics diagnostics;
  if (joint_count < 3) {
    diagnostics.error(Code::kWrongSize, {}, fmt::format("the chain has {} joints", joint_count),
                      "Use three or more, to reach any position");
    return diagnostics;
  }
  const int wanted = std::max(0, joint_count - 6);
  if (static_cast<int>(held.size()) != wanted)
    diagnostics.error(Code::kWrongSize, {}, fmt::format("{} held joints for a chain of {}", held.size(), joint_count),
                      wanted == 0 ? std::string("none") : fmt::format("Give {}, so that six remain", wanted));
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i] < 0 || held[i] >= joint_count)
      diagnostics.error(Code::kOutOfRange, pointer_segment(i), fmt::format("held joint {}", held[i]),
                        fmt::format("Choose 0 to {}", joint_count - 1));
    if (std::find(held.begin(), held.begin() + static_cast<std::ptrdiff_t>(i), held[i]) !=
        held.begin() + static_cast<std::ptrdiff_t>(i))
      diagnostics.error(Code::kDuplicate, pointer_segment(i), fmt::format("joint {} is held twice", held[i]));
  }
  return diagnostics;
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
  Diagnostics diagnostics = check_held(chain.joint_count(), held_joints);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
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
    return failure(Code::kWrongSize, {},
                   fmt::format("a chain of {} joints has no default held joints", chain.joint_count()),
                   fmt::format("Name {}", chain.joint_count() - 6));
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
  at.linearised = true;
  if (!is_short()) {
    at.pivot = at.lu.factor(at.A);
    return;
  }
  for (int k = free_count_; k < 6; ++k) at.A.col(k).setZero();
  const Matrix6 L = normal_of(at.A).llt().matrixL();
  at.pivot = L.diagonal().head(free_count_).minCoeff();
}

Vector6 InverseKinematics::solve_free(const Linear& at, const Vector6& y) const {
  if (!is_short()) return at.lu.solve(y);
  Matrix6 A = at.A;
  A.bottomRows<3>() *= kTurnWeight;
  Vector6 right = y;
  right.tail<3>() *= kTurnWeight;
  const Eigen::LLT<Matrix6> normal = normal_of(A).llt();
  Vector6 x = normal.solve(A.transpose().lazyProduct(right).eval());
  // Normal equations square the condition; a second step on what is left gives the lost digits back.
  right -= A.lazyProduct(x);
  x += normal.solve(A.transpose().lazyProduct(right).eval());
  return x;
}

bool InverseKinematics::is_met(const Vector6& error) const {
  const double place = error.head<3>().cwiseAbs().maxCoeff(), turn = error.tail<3>().cwiseAbs().maxCoeff();
  constexpr double kPlaceSlack = 1e-8;  // of the reach: what kTurnWeight leaves of kTurnSlack
  return is_short() ? place <= kPlaceSlack * length_scale_ && turn <= kTurnSlack : place <= tolerance_ && turn <= 1e-12;
}

IkStatus InverseKinematics::converge(const Eigen::Isometry3d& X_BF, const JointVector& held, double last_step,
                                     JointVector& q, Linear& at) const {
  for (std::size_t i = 0; i < held_joints_.size(); ++i) q[held_joints_[i]] = held[static_cast<Eigen::Index>(i)];
  const JointVector seed = q;
  bool settled = false;
  for (int step = 0; step < kMaxSteps; ++step) {
    chain_.jacobian(q, at.X_BF, at.J);
    at.linearised = false;
    const Vector6 error = pose_error(at.X_BF, X_BF);
    if (!is_short() && is_met(error)) return IkStatus::kOk;

    linearise(at);
    const Vector6 e = weighted(error);
    const bool damped = !(at.pivot > kDampedBelow);
    Vector6 delta = damped ? damped_step(at.A, e) : solve_free(at, e);
    const double longest = delta.cwiseAbs().maxCoeff();
    if (longest > kMaxStep) delta *= kMaxStep / longest;
    double travel = 0.0;
    for (int k = 0; k < free_count_; ++k) {
      const int joint = free_joints_[static_cast<std::size_t>(k)];
      q[joint] += delta[k];
      travel = std::max(travel, std::abs(q[joint] - seed[joint]));
    }
    // With fewer joints than equations a small step says where it ends, and the error whether that is near enough.
    const bool ends = !damped && delta.cwiseAbs().sum() <= (is_short() ? kLastStepOfFewer : last_step);
    if (ends && (!is_short() || is_met(error))) return IkStatus::kOk;
    if (ends && settled) break;
    settled = ends;  // the error was that before the step: it is looked at once more
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
  const Vector6 free = solve_free(at, weighted(rest));
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
  if (!is_short() || !(at.pivot > kSingularBelow)) return Vector6::Zero();
  const Vector6 way = weighted(pose_error(at.X_BF, X_BF));
  const Vector6 free = normal_of(at.A).llt().solve(at.A.transpose().lazyProduct(way).eval());
  Vector6 beyond = way - at.A * free;
  beyond.head<3>() *= length_scale_;
  return beyond;
}

IkStatus InverseKinematics::pass(const JointVector& q, const Goal& goal, double least_measure, Passage& passage) const {
  Linear at;
  chain_.jacobian(q, at.X_BF, at.J);
  linearise(at);
  if (!(at.pivot > kSingularBelow)) return IkStatus::kSingular;
  passage.dq = solve_linear(at, goal.V_BF_B, goal.held_dq);
  passage.ddq = solve_linear(at, goal.A_BF_B - chain_.bias(at.J, passage.dq), goal.held_ddq);
  passage.regular = is_regular(at, least_measure);
  return IkStatus::kOk;
}

double InverseKinematics::smallest_singular_value(const Linear& at) const {
  return Eigen::JacobiSVD<Matrix6>(at.A).singularValues()[free_count_ - 1];
}

double InverseKinematics::singularity_measure(const JointVector& q) const {
  Linear at;
  chain_.jacobian(q, at.X_BF, at.J);
  linearise(at);
  return smallest_singular_value(at);
}

bool InverseKinematics::is_regular(const Linear& at, double least) const {
  // All singular values are above `least` if A^T A less its square is positive definite, which a Cholesky
  // factorisation tells in a twentieth of their time. What it can be wrong by in rounding, it must be above.
  constexpr double kRounding = 1e-12;
  Matrix6 above = gram_of(at.A);
  above.diagonal().array() -= least * least + kRounding * above.trace();
  for (int k = free_count_; k < 6; ++k) above(k, k) = 1.0;
  return is_positive_definite(above) || smallest_singular_value(at) >= least;
}

double limit_distance(const Chain& chain, const JointVector& q) {
  double distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < chain.joint_count(); ++i)
    distance = std::min({distance, q[i] - chain.lower()[i], chain.upper()[i] - q[i]});
  return distance;
}

}  // namespace takt::kinematics
