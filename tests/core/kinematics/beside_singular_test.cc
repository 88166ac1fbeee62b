// Poses at and beside singular postures, as files write them: any arm, any kind of singular posture, any number of
// digits. What is within reach is found, within 1e-9.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "core/kinematics/inverse.h"
#include "core/kinematics/pose_error.h"
#include "core/kinematics/solutions.h"
#include "tests/core/kinematics/robots.h"

namespace takt::kinematics {
namespace {

using test::pose_distance;
using test::random_q;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kFound = 1e-9;  // m and rad

/// An arm with six joints that are free and others that are held.
struct Six {
  std::string name;
  Chain chain;
  std::vector<int> free, held;
};

Six six_of(const std::string& name, const Chain& chain, const std::vector<int>& held) {
  Six arm{name, chain, {}, held};
  for (int i = 0; i < chain.joint_count(); ++i)
    if (std::ranges::find(held, i) == held.end()) arm.free.push_back(i);
  return arm;
}

std::vector<Six> all_arms() {
  std::vector<Six> arms{six_of("lwr", test::lwr(), {2}), six_of("ur5", test::chain_of(test::ur5_urdf()), {}),
                        six_of("tx90", test::chain_of(test::tx90_urdf()), {})};
  for (const test::ForeignArm& arm : test::foreign_arms())
    arms.push_back(six_of(arm.name, test::chain_of(arm.urdf), arm.held));
  return arms;
}

Matrix6 free_jacobian(const Six& arm, const JointVector& q, Eigen::Isometry3d& X_BF) {
  Jacobian J;
  arm.chain.jacobian(q, X_BF, J);
  Matrix6 A;
  for (std::size_t k = 0; k < 6; ++k) A.col(static_cast<Eigen::Index>(k)) = J.col(arm.free[k]);
  A.topRows<3>() /= std::max(arm.chain.reach(), 1e-3);
  return A;
}

double determinant(const Six& arm, const JointVector& q) {
  Eigen::Isometry3d X_BF;
  return free_jacobian(arm, q, X_BF).determinant();
}

/// A value of one joint at which the arm is singular, the others as they are: by bisection, so of any kind.
std::optional<double> singular_at(const Six& arm, JointVector q, int joint) {
  constexpr int kParts = 40;
  const double low = std::max(arm.chain.lower()[joint], -3.1), high = std::min(arm.chain.upper()[joint], 3.1);
  const auto at = [&](double value) {
    q[joint] = value;
    return determinant(arm, q);
  };
  for (int k = 0; k < kParts; ++k) {
    double a = low + (high - low) * k / kParts, b = low + (high - low) * (k + 1) / kParts;
    const double side = at(a);
    if (side * at(b) >= 0.0) continue;
    for (int step = 0; step < 80; ++step) (at(0.5 * (a + b)) * side > 0.0 ? a : b) = 0.5 * (a + b);
    return 0.5 * (a + b);
  }
  return std::nullopt;
}

/// A pose as a file has it with that many digits behind the point.
Eigen::Isometry3d written(const Eigen::Isometry3d& X, int digits) {
  if (digits >= 17) return X;
  const double unit = std::pow(10.0, digits);
  const auto round = [&](double value) { return std::round(value * unit) / unit; };
  const Eigen::Quaterniond q(X.linear());
  Eigen::Isometry3d Y = Eigen::Isometry3d::Identity();
  Y.linear() =
      Eigen::Quaterniond(round(q.w()), round(q.x()), round(q.y()), round(q.z())).normalized().toRotationMatrix();
  Y.translation() = X.translation().unaryExpr(round);
  return Y;
}

/// The oracle: least squares by singular values, the smallest of which are left out step by step, from many places
/// around q. Slow, and it shares nothing with the solver but the chain. Whether it gets there inside the limits.
bool is_within_reach(const Six& arm, const Eigen::Isometry3d& X_BF, const JointVector& q) {
  Random random(7, "oracle");
  for (int attempt = 0; attempt < 24; ++attempt) {
    JointVector x = q;
    for (const int i : arm.free) x[i] += attempt == 0 ? 0.0 : random.uniform(-0.2, 0.2);
    for (int step = 0; step < 120; ++step) {
      Eigen::Isometry3d X;
      const Matrix6 A = free_jacobian(arm, x, X);
      Vector6 error = pose_error(X, X_BF);
      if (error.cwiseAbs().maxCoeff() < 1e-11) break;
      error.head<3>() /= std::max(arm.chain.reach(), 1e-3);
      const Eigen::JacobiSVD<Matrix6> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
      const double damping = 0.3 * error.norm();
      Vector6 turned = svd.matrixU().transpose() * error;
      for (int i = 0; i < 6; ++i) {
        const double s = svd.singularValues()[i];
        turned[i] *= s / (s * s + damping * damping * (step % 3 == 0 ? 0.0 : 1.0) + 1e-26);
      }
      Vector6 way = svd.matrixV() * turned;
      if (way.norm() > 0.3) way *= 0.3 / way.norm();
      for (std::size_t k = 0; k < 6; ++k) x[arm.free[k]] += way[static_cast<Eigen::Index>(k)];
    }
    if (pose_distance(arm.chain.forward(x), X_BF) < 1e-10 && limit_distance(arm.chain, x) >= 0.0) return true;
  }
  return false;
}

struct BesideTally {
  int poses = 0, missed = 0, off = 0;
};

int rounds_wanted() {
  const char* wanted = std::getenv("TAKT_ROUNDS");
  return wanted != nullptr ? std::max(1, std::atoi(wanted)) : 300;
}

/// Poses of an arm one of whose joints is bent to where it is singular, and a little off.
BesideTally beside(const Six& arm, int count, Random& random) {
  constexpr std::array<int, 8> kDigits = {4, 6, 8, 9, 10, 12, 15, 17};
  BesideTally tally;
  for (int round = 0; round < count; ++round) {
    JointVector q = random_q(random, arm.chain);
    const int joint = arm.free[random.bits() % 6];
    const auto place = singular_at(arm, q, joint);
    const double bend = round % 12 == 0 ? 0.0 : random.uniform(-1.0, 1.0) * std::pow(10.0, -2.0 - round % 11);
    const int digits = kDigits[random.bits() % kDigits.size()];
    if (!place) continue;
    q[joint] = std::clamp(*place + bend, arm.chain.lower()[joint], arm.chain.upper()[joint]);
    const Eigen::Isometry3d X_BF = written(arm.chain.forward(q), digits);
    SolutionOptions options;
    options.reference = random_q(random, arm.chain);
    options.turns = false;
    if (!arm.held.empty()) {
      options.held_joint = arm.held.front();
      options.held_values = {q[options.held_joint]};
    }
    const auto found = inverse_solutions(arm.chain, X_BF, options);
    for (const JointVector& s : found) {
      // A joint that was brought to the end of its range may miss a pose by what six digits leave open.
      const double allowed = limit_distance(arm.chain, s) == 0.0 ? 1e-6 : kFound;
      if (!(pose_distance(arm.chain.forward(s), X_BF) <= allowed) || limit_distance(arm.chain, s) < 0.0) ++tally.off;
    }
    if (found.empty() && !is_within_reach(arm, X_BF, q)) continue;
    ++tally.poses;
    tally.missed += found.empty() ? 1 : 0;
  }
  return tally;
}

TEST(BesideSingularPostures, PosesOfAnyNumberOfDigitsAreFound) {
  Random random(41, "digits");
  for (const Six& arm : all_arms()) {
    SCOPED_TRACE(arm.name);
    const BesideTally tally = beside(arm, rounds_wanted(), random);
    EXPECT_GT(tally.poses, rounds_wanted() / 5);
    EXPECT_EQ(tally.missed, 0);
    EXPECT_EQ(tally.off, 0);
  }
}

}  // namespace
}  // namespace takt::kinematics
