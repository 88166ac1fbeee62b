#include "core/kinematics/arm_angle.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/kinematics/inverse.h"
#include "core/kinematics/posture.h"
#include "core/kinematics/solutions.h"
#include "tests/core/kinematics/robots.h"

namespace takt::kinematics {
namespace {

using test::pose_distance;
using test::random_q;

TEST(ArmAngle, OnlyShoulderElbowWristArmsHaveOne) {
  EXPECT_TRUE(ArmAngle::recognise(test::lwr()));
  EXPECT_FALSE(ArmAngle::recognise(test::chain_of(test::ur5_urdf())));
  for (const test::ForeignArm& arm : test::foreign_arms()) {
    EXPECT_FALSE(ArmAngle::recognise(test::chain_of(arm.urdf))) << arm.name;
  }
}

TEST(ArmAngle, HangsOnTheElbowAlone) {
  // The upper arm leans forwards, the elbow is bent upwards: the elbow lies in the half plane of axis 1.
  const Chain chain = test::lwr();
  const auto arm = ArmAngle::recognise(chain);
  JointVector q(7);
  q << 0.4, -0.3, 0.0, 1.2, 0.2, 0.7, 0.1;
  EXPECT_NEAR(arm->of(q).value(), 0.0, 1e-12);
  q[3] = -1.2;
  q[1] = 0.9;
  EXPECT_NEAR(std::abs(arm->of(q).value()), 0.0, 1e-12) << "leaning the other way and bent the other way";
  q << 0.4, -0.9, 0.0, -1.2, 0.2, 0.7, 0.1;
  EXPECT_NEAR(std::abs(arm->of(q).value()), std::numbers::pi, 1e-12) << "the elbow hangs";
}

TEST(ArmAngle, SwivelsTheElbowOnly) {
  const Chain chain = test::lwr();
  const auto arm = ArmAngle::recognise(chain);
  Random random(8, "swivel");
  int compared = 0;
  for (int round = 0; round < 300; ++round) {
    const JointVector q = random_q(random, chain);
    const auto angle = arm->of(q);
    if (!angle || singularity(chain, q).measure < 1e-2) continue;
    for (const double by : {-2.0, -0.1, 0.0, 0.3, 3.0}) {
      const double wanted = std::remainder(*angle + by, 2.0 * std::numbers::pi);
      const auto solutions = arm->solve(chain.forward(q), wanted);
      EXPECT_GE(solutions.size(), 4u);
      double nearest = 1.0;
      for (const JointVector& s : solutions) {
        EXPECT_LT(pose_distance(chain.forward(s), chain.forward(q)), 1e-9);
        EXPECT_LT(std::abs(std::remainder(arm->of(s).value() - wanted, 2.0 * std::numbers::pi)), 1e-8);
        nearest = std::min(nearest, (s - q).cwiseAbs().maxCoeff());
        ++compared;
      }
      EXPECT_LT(by == 0.0 ? nearest : 0.0, 1e-8);
    }
  }
  EXPECT_GT(compared, 5000);
}

TEST(ArmAngle, IsUndefinedWhereTheElbowHasNoCircle) {
  const Chain chain = test::lwr();
  const auto arm = ArmAngle::recognise(chain);
  JointVector q = JointVector::Zero(7);
  EXPECT_FALSE(arm->of(q)) << "stretched, and above axis 1";
  q << 0, 0.5, 0, 0, 0, 0.3, 0;
  EXPECT_FALSE(arm->of(q)) << "stretched";
  // Wrist straight above the shoulder, elbow bent.
  q << 0, -0.6, 0, 1.2, 0, 0.3, 0;
  q[1] = std::atan2(0.39 * std::sin(1.2), 0.4 + 0.39 * std::cos(1.2));
  EXPECT_FALSE(arm->of(q));
  EXPECT_TRUE(arm->solve(chain.forward(q), 0.0).empty());
}

TEST(InverseSolutions, AtArmAnglesInsteadOfAHeldJoint) {
  const Chain chain = test::lwr();
  const auto arm = ArmAngle::recognise(chain);
  Random random(9, "angles");
  SolutionOptions options;
  options.turns = false;
  for (int round = 0; round < 200; ++round) {
    const JointVector q = random_q(random, chain);
    const auto angle = arm->of(q);
    if (!angle || singularity(chain, q).measure < 1e-3) continue;
    options.reference = q;
    options.arm_angles = {*angle};
    const auto found = inverse_solutions(chain, chain.forward(q), options);
    ASSERT_FALSE(found.empty());
    EXPECT_LT((found.front() - q).norm(), 1e-7);
    for (const JointVector& s : found) EXPECT_GE(limit_distance(chain, s), 0.0);
    options.arm_angles = arm_angle_grid(12);
    EXPECT_GE(inverse_solutions(chain, chain.forward(q), options).size(), 1u);
  }
  options.arm_angles = {0.0};
  options.reference = {};
  const Chain ur5 = test::chain_of(test::ur5_urdf());
  EXPECT_TRUE(inverse_solutions(ur5, ur5.forward(JointVector::Constant(6, 0.7)), options).empty());
  EXPECT_EQ(arm_angle_grid(4).size(), 4u);
}

}  // namespace
}  // namespace takt::kinematics
