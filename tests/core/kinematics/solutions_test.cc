#include "core/kinematics/solutions.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/kinematics/inverse.h"
#include "tests/core/kinematics/robots.h"

namespace takt::kinematics {
namespace {

using test::pose_distance;
using test::random_q;

double distance(const JointVector& a, const JointVector& b) { return (a - b).cwiseAbs().maxCoeff(); }

void expect_valid(const Chain& chain, const Eigen::Isometry3d& X_BF, const JointVector& reference,
                  const std::vector<JointVector>& solutions) {
  for (std::size_t i = 0; i < solutions.size(); ++i) {
    EXPECT_LT(pose_distance(chain.forward(solutions[i]), X_BF), 1e-11);
    EXPECT_GE(limit_distance(chain, solutions[i]), 0.0);
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT(distance(solutions[i], solutions[j]), 1e-6) << "distinct";
    if (i == 0) continue;
    EXPECT_GE((solutions[i] - reference).norm(), (solutions[i - 1] - reference).norm()) << "sorted";
  }
}

TEST(InverseSolutions, EveryReachablePoseOfTheLwrIsReached) {
  const Chain chain = test::lwr();
  Random random(17, "reach");
  SolutionOptions options;
  options.enough = 1;
  int failures = 0;
  for (int round = 0; round < 10'000; ++round) {
    const JointVector q = random_q(random, chain);
    const Eigen::Isometry3d X_BF = chain.forward(q);
    const auto solutions = inverse_solutions(chain, X_BF, options);
    if (solutions.empty()) {
      ++failures;
      continue;
    }
    EXPECT_LT(pose_distance(chain.forward(solutions.front()), X_BF), 1e-11);
    EXPECT_GE(limit_distance(chain, solutions.front()), 0.0);
  }
  EXPECT_EQ(failures, 0);
}

/// Every solution of `some` is among `all`.
void expect_among(const std::vector<JointVector>& some, const std::vector<JointVector>& all) {
  for (const JointVector& q : some) {
    const auto same = [&](const JointVector& other) { return distance(other, q) < 1e-5; };
    EXPECT_TRUE(std::any_of(all.begin(), all.end(), same)) << q.transpose();
  }
}

/// The closed form and the numeric search, which share nothing but the chain, give the same solutions, and the joints
/// that made the pose are among them.
void compare_ways(const Chain& chain, bool held, int rounds) {
  Random random(18, "ways");
  std::size_t most = 0;
  for (int round = 0; round < rounds; ++round) {
    const JointVector q = random_q(random, chain);
    SolutionOptions options;
    options.reference = q;
    options.most = options.enough = 5000;
    if (held) options.held_values = {q[2]};
    const Eigen::Isometry3d X_BF = chain.forward(q);
    const auto closed = inverse_solutions(chain, X_BF, options);
    options.closed_form = false;
    const auto searched = inverse_solutions(chain, X_BF, options);
    expect_valid(chain, X_BF, q, closed);
    expect_valid(chain, X_BF, q, searched);
    expect_among(searched, closed);
    expect_among(closed, searched);
    ASSERT_FALSE(closed.empty());
    EXPECT_LT(distance(closed.front(), q), 1e-6) << "the one that made the pose is the nearest to itself";
    for (const JointVector& solution : closed) EXPECT_TRUE(!held || solution[2] == q[2]) << "held to the bit";
    most = std::max(most, closed.size());
  }
  EXPECT_GE(most, 8u);
}

TEST(InverseSolutions, TwoWaysAgreeForTheLwrWithItsThirdJointHeld) { compare_ways(test::lwr(), true, 20); }
TEST(InverseSolutions, TwoWaysAgreeForTheUr5) { compare_ways(test::chain_of(test::ur5_urdf()), false, 4); }
TEST(InverseSolutions, TwoWaysAgreeForTheTx90) { compare_ways(test::chain_of(test::tx90_urdf()), false, 10); }

TEST(InverseSolutions, ReferenceChoosesTheNearestAndUnreachableGivesNone) {
  const Chain chain = test::lwr();
  JointVector home(7);
  home << 0, -0.5236, 0, 1.5708, 0, -1.0472, 0;
  SolutionOptions options;
  options.reference = home;
  options.most = 3;
  const auto solutions = inverse_solutions(chain, chain.forward(home), options);
  ASSERT_EQ(solutions.size(), 3u);
  EXPECT_LT(distance(solutions.front(), home), 1e-9);
  expect_valid(chain, chain.forward(home), home, solutions);
  EXPECT_EQ(solutions, inverse_solutions(chain, chain.forward(home), options)) << "the same bits again";

  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation().x() = 2.0;
  EXPECT_TRUE(inverse_solutions(chain, far).empty());
  far.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(inverse_solutions(chain, far).empty());
}

TEST(InverseSolutions, ChainsOfAnyLength) {
  Random random(20, "any");
  for (int joints = 6; joints <= 10; ++joints) {
    int reached = 0;
    for (int round = 0; round < 5; ++round) {
      const auto chain = Chain::create(test::random_model(random, joints), "l0", "flange");
      const JointVector q = random_q(random, *chain);
      SolutionOptions options;
      options.enough = 4;
      const auto solutions = inverse_solutions(*chain, chain->forward(q), options);
      for (const JointVector& s : solutions) EXPECT_LT(pose_distance(chain->forward(s), chain->forward(q)), 2e-11);
      reached += solutions.empty() ? 0 : 1;
    }
    EXPECT_EQ(reached, 5) << joints;
  }
}

}  // namespace
}  // namespace takt::kinematics
