#include "core/kinematics/closed_form.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/kinematics/posture.h"
#include "core/kinematics/solutions.h"
#include "tests/core/kinematics/robots.h"

namespace takt::kinematics {
namespace {

using test::pose_distance;
using test::random_q;

double turned_distance(const JointVector& a, const JointVector& b) {
  JointVector difference = a - b;
  for (double& d : difference) d = std::remainder(d, 2.0 * std::numbers::pi);
  return difference.cwiseAbs().maxCoeff();
}

/// All candidates make the pose before any polish, and the joints that made it are among them.
void expect_all(const Chain& chain, const std::vector<int>& held, int rounds, double pose_within, double q_within) {
  Random random(5, "closed");
  std::array<int, 17> counts{};
  for (int round = 0; round < rounds; ++round) {
    const JointVector q = random_q(random, chain);
    if (singularity(chain, q).measure < 1e-3) continue;
    const auto form = ClosedForm::recognise(chain, q, held);
    ASSERT_TRUE(form);
    ClosedForm::Candidates found;
    form->solve(chain.forward(q), found);
    double nearest = 1.0;
    for (int i = 0; i < found.count; ++i) {
      const JointVector candidate = form->joints(found.angles[static_cast<std::size_t>(i)]);
      EXPECT_LT(pose_distance(chain.forward(candidate), chain.forward(q)), pose_within);
      EXPECT_LE(candidate.cwiseAbs().maxCoeff(), std::max(std::numbers::pi, q.cwiseAbs().maxCoeff()));
      nearest = std::min(nearest, turned_distance(candidate, q));
    }
    EXPECT_LT(nearest, q_within) << q.transpose();
    ++counts[static_cast<std::size_t>(found.count)];
  }
  EXPECT_GT(counts[8], 0) << "all eight branches are met";
  EXPECT_EQ(counts[0] + counts[1], 0);
}

TEST(ClosedForm, OurArms) {
  expect_all(test::lwr(), {2}, 3000, 1e-7, 1e-7);
  expect_all(test::chain_of(test::ur5_urdf()), {}, 3000, 1e-7, 1e-7);
  expect_all(test::chain_of(test::tx90_urdf()), {}, 3000, 1e-7, 1e-7);
}

TEST(ClosedForm, ForeignArmsAreRecognisedByTheirAxesAlone) {
  for (const test::ForeignArm& arm : test::foreign_arms()) {
    SCOPED_TRACE(arm.name);
    const Chain chain = test::chain_of(arm.urdf);
    const auto form = ClosedForm::recognise(chain, JointVector::Constant(chain.joint_count(), 0.3), arm.held);
    EXPECT_EQ(form ? to_string(form->family()) : "", arm.family);
    if (!form) continue;
    EXPECT_EQ(form->reversed(), arm.reversed);
    // A rounded right angle costs 1e-5; the quartic half the digits.
    const bool crooked = arm.name == "rounded" || arm.name == "crooked";
    expect_all(chain, arm.held, 1000, crooked ? 1e-2 : 1e-6, crooked ? 1e-2 : 1e-6);
  }
}

TEST(ClosedForm, TheRedundantJointIsTheOneThatLeavesAClosedForm) {
  EXPECT_EQ(redundant_joint(test::lwr()), 2);
  const Chain offset_wrist = test::chain_of(test::foreign_arms()[4].urdf);
  EXPECT_EQ(redundant_joint(offset_wrist), 6);
  Random random(5, "seven");
  const JointVector q = random_q(random, offset_wrist);
  SolutionOptions options;
  options.reference = q;
  const auto found = inverse_solutions(offset_wrist, offset_wrist.forward(q), options);
  ASSERT_FALSE(found.empty());
  EXPECT_LT((found.front() - q).norm(), 1e-7);
}

TEST(ClosedForm, GeometriesWithoutOneAreToldApart) {
  Random random(3);
  const auto any = Chain::create(test::random_model(random, 6), "l0", "flange");
  EXPECT_FALSE(ClosedForm::recognise(*any, JointVector::Zero(6), {}));
  const JointVector zero = JointVector::Zero(7);
  EXPECT_TRUE(ClosedForm::recognise(test::lwr(), zero, {0})) << "axes 2 and 3 meet in the shoulder too";
  EXPECT_TRUE(ClosedForm::recognise(test::lwr(), zero, {4})) << "solved from its flange";
  EXPECT_FALSE(ClosedForm::recognise(test::lwr(), zero, {})) << "seven free joints";
}

}  // namespace
}  // namespace takt::kinematics
