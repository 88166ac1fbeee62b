#include "core/kinematics/joint_range.h"

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "core/kinematics/inverse.h"
#include "core/kinematics/solutions.h"
#include "tests/core/kinematics/robots.h"

namespace takt::kinematics {
namespace {

TEST(JointRange, WhatIsAtAnEndGoesThere) {
  EXPECT_EQ(into_range(1.0 + 0.9 * kRangeTolerance, -1.0, 1.0), 1.0);
  EXPECT_EQ(into_range(-1.0 - 0.9 * kRangeTolerance, -1.0, 1.0), -1.0);
  EXPECT_EQ(into_range(0.3, -1.0, 1.0), 0.3);
  const double outside = 1.0 + 1.1 * kRangeTolerance;
  EXPECT_EQ(into_range(outside, -1.0, 1.0), outside) << "not brought in: refused by who looks";
  EXPECT_FALSE(is_in_range(outside, -1.0, 1.0));
  EXPECT_FALSE(is_in_range(std::numeric_limits<double>::quiet_NaN(), -1.0, 1.0));
}

TEST(JointRange, EndlessJointsGoToTheNearestTurn) {
  RobotModel model = test::model_of(test::tx90_urdf());
  model.joints[0].type = JointType::kContinuous;
  model.joints[0].upper = std::numeric_limits<double>::infinity();
  model.joints[0].lower = -model.joints[0].upper;
  const Chain chain = *Chain::create(model, "base", "flange");
  constexpr double kTurn = 2.0 * std::numbers::pi;
  JointVector q = JointVector::Zero(6), near = JointVector::Zero(6);
  q[0] = -3.0;
  q[5] = -3.0;
  near[0] = 3.0 + 60 * kTurn;
  near[5] = 3.0;
  const JointVector turned = in_nearest_turns(chain, q, near);
  EXPECT_NEAR(turned[0], -3.0 + 61 * kTurn, 1e-12);
  EXPECT_EQ(turned[5], -3.0) << "a joint with limits keeps its turn";
  EXPECT_EQ(in_nearest_turns(chain, q, q), q) << "to the bit";
}

/// The posture that stands at an end of its range is a solution of its pose, whatever rounding does to it.
TEST(JointRange, PosturesAtTheEndsAreSolutions) {
  Random random(61, "ends");
  for (const auto& urdf : {test::tx90_urdf(), test::ur5_urdf(), test::lwr_urdf()}) {
    const Chain chain = test::chain_of(urdf);
    const auto inverse = InverseKinematics::create(chain);
    for (int round = 0; round < 600; ++round) {
      JointVector q = test::random_q(random, chain);
      const int joint = round % chain.joint_count();
      q[joint] = random.bits() % 2 == 0 ? chain.lower()[joint] : chain.upper()[joint];
      if (inverse->singularity_measure(q) < 0.02) continue;
      SolutionOptions options;
      options.reference = q;
      options.reference[(joint + 1) % chain.joint_count()] *= 0.999;
      options.turns = false;
      if (chain.joint_count() == 7) options.held_values = {q[2]};
      Eigen::Isometry3d X_BF = chain.forward(q);
      if (round % 3 == 0)  // as a file has it
        X_BF.translation() = (X_BF.translation() * 1e8).array().round().matrix() / 1e8;
      const auto found = inverse_solutions(chain, X_BF, options);
      ASSERT_FALSE(found.empty());
      EXPECT_LT((found.front() - q).cwiseAbs().maxCoeff(), 1e-5) << q.transpose();
      EXPECT_GE(limit_distance(chain, found.front()), 0.0);
    }
  }
}

}  // namespace
}  // namespace takt::kinematics
