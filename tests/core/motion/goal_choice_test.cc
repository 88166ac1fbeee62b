#include "core/motion/goal_choice.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/kinematics/solutions.h"
#include "tests/core/motion/motion_runs.h"
#include "tests/support/reports.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

using kinematics::Chain;
namespace robots = kinematics::test;

TEST(ChooseSolution, TakesTheNearestByWeightedDistance) {
  Random random(51);
  const Chain chain = robots::chain_of(robots::ur5_urdf());
  const JointLimits limits = random_limits(random, chain);
  for (int i = 0; i < 10; ++i) {
    const JointVector q_near = 0.5 * robots::random_q(random, chain);
    const Eigen::Isometry3d X = chain.forward(0.5 * robots::random_q(random, chain));
    const JointVector weights = JointVector::Constant(6, 1.0) + robots::random_vector(random, 6, 0.9);
    const auto chosen = choose_solution(chain, limits, X, q_near, weights);
    ASSERT_TRUE(chosen) << chosen.error().to_string();
    EXPECT_LT(robots::pose_distance(chain.forward(*chosen), X), 1e-9);
    kinematics::SolutionOptions search;
    search.reference = q_near;
    for (const JointVector& other : inverse_solutions(chain, X, search)) {
      EXPECT_LE(weights.cwiseProduct(*chosen - q_near).norm(), weights.cwiseProduct(other - q_near).norm() + 1e-12);
    }
  }
}

TEST(ChooseSolution, StaysWhereItIsIfThatIsAnAnswer) {
  Random random(52);
  const Chain chain = robots::lwr();
  const JointLimits limits = random_limits(random, chain);
  JointVector q(7);
  q << 0.1, -0.5, 0.2, 1.5, 0.1, -1.0, 0.3;
  const auto chosen = choose_solution(chain, limits, chain.forward(q), q);
  ASSERT_TRUE(chosen);
  EXPECT_LT((*chosen - q).norm(), 1e-9);
}

TEST(ChooseSolution, KeepsToTheRangesThatItIsGiven) {
  Random random(53);
  const Chain chain = robots::lwr();
  JointLimits limits = random_limits(random, chain);
  JointVector q(7);
  q << 0.1, -0.5, 0.2, 1.5, 0.1, -1.0, 0.3;
  limits.lower[5] = 0.0;  // only the other wrist
  const auto chosen = choose_solution(chain, limits, chain.forward(q), q);
  ASSERT_TRUE(chosen) << chosen.error().to_string();
  EXPECT_GE((*chosen)[5], 0.0);
  EXPECT_LT(robots::pose_distance(chain.forward(*chosen), chain.forward(q)), 1e-9);
}

TEST(ChooseSolution, SaysWhyThereIsNone) {
  Random random(54);
  const Chain chain = robots::lwr();
  JointLimits limits = random_limits(random, chain);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << 2.0, 0.0, 0.5;
  const JointVector near = JointVector::Zero(7);
  EXPECT_THAT(choose_solution(chain, limits, X, near).error(), Reports(Code::kUnreachable, "/goal", {"2.062"}));
  X.translation().x() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(choose_solution(chain, limits, X, near).error(), Reports(Code::kOutOfRange, "/goal"));
  JointVector q(7);
  q << 0.1, -0.5, 0.2, 1.5, 0.1, -1.0, 0.3;
  limits.lower = q + JointVector::Constant(7, 0.01);
  limits.upper = q + JointVector::Constant(7, 0.02);
  EXPECT_THAT(choose_solution(chain, limits, chain.forward(q), q).error(), Reports(Code::kUnreachable, "/goal"));
}

}  // namespace
}  // namespace takt::motion::test
