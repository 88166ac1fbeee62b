#include "core/kinematics/differential.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace takt::kinematics {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Squares of the singular values, ascending.
Vector6 squares(const Jacobian& J) {
  const Matrix6 A = J * J.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(A, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseMax(0.0);
}

Jacobian weighted(const Jacobian& J, double length) {
  Jacobian scaled = J;
  scaled.topRows<3>() /= length;
  return scaled;
}

/// The rate with which a joint can still stop within `distance`, losing acceleration * period in each period: the
/// largest v with v h + (v - a h) h + ... <= distance.
double stoppable(double distance, double acceleration, double period) {
  if (!(distance > 0.0)) return 0.0;
  const double step = acceleration * period;
  // n whole periods of braking take n (n + 1) / 2 steps of the velocity; in between it grows in proportion.
  const double steps = std::min(distance / (step * period), 1e12);  // a limit may be infinitely far away
  const double n = std::floor(0.5 * (std::sqrt(1.0 + 8.0 * steps) - 1.0));
  return step * (n + (steps - 0.5 * n * (n + 1.0)) / (n + 1.0));
}

}  // namespace

Dexterity dexterity(const Jacobian& J, double length) {
  const Vector6 s = squares(weighted(J, length)).cwiseSqrt();
  return {.manipulability = s.prod(), .smallest = s[0], .condition = s[5] > 0.0 ? s[0] / s[5] : 0.0};
}

RateBounds rate_bounds(const JointVector& q, const JointVector& lower, const JointVector& upper,
                       const JointVector& velocity, const JointVector& acceleration, double period) {
  RateBounds bounds{.lower = q, .upper = q};
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    bounds.upper[i] = std::min(velocity[i], stoppable(upper[i] - q[i], acceleration[i], period));
    bounds.lower[i] = -std::min(velocity[i], stoppable(q[i] - lower[i], acceleration[i], period));
  }
  return bounds;
}

JointVector bounded_rates(const Jacobian& J, const Vector6& V_BF_B, const RateBounds& bounds, double length,
                          double damped_below) {
  const Eigen::Index n = J.cols();
  Jacobian free = weighted(J, length);
  Vector6 V = V_BF_B;
  V.head<3>() /= length;
  JointVector dq = JointVector::Zero(n);
  Eigen::Array<bool, Eigen::Dynamic, 1, 0, kMaxJoints, 1> held(n);
  held.setConstant(false);
  for (Eigen::Index round = 0; round <= n; ++round) {
    const double smallest = std::sqrt(squares(free)[0]);
    const double lack = std::max(0.0, 1.0 - smallest / damped_below);
    const double damping = damped_below * lack;
    // A trace of damping always: what is held leaves directions that no joint can move any more.
    const Matrix6 A = free * free.transpose() + (damping * damping + 1e-12) * Matrix6::Identity();
    const JointVector wanted = free.transpose() * A.ldlt().solve(V);
    // The joint that is furthest outside is held at its bound, and its part taken out of what is wanted.
    Eigen::Index worst = -1;
    double excess = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (held[i]) continue;
      dq[i] = std::clamp(wanted[i], bounds.lower[i], bounds.upper[i]);
      const double beyond = std::abs(wanted[i] - dq[i]);
      if (!(beyond > excess)) continue;
      excess = beyond;
      worst = i;
    }
    if (worst < 0) break;
    held[worst] = true;
    V -= free.col(worst) * dq[worst];
    free.col(worst).setZero();
  }
  // What is not finite (a twist beyond all numbers) moves nothing faster than allowed either.
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!std::isfinite(dq[i])) dq[i] = std::clamp(0.0, bounds.lower[i], bounds.upper[i]);
  }
  return dq;
}

}  // namespace takt::kinematics
