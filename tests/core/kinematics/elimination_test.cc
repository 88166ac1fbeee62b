#include "core/kinematics/elimination.h"

#include <gtest/gtest.h>

#include "core/kinematics/closed_form.h"
#include "core/kinematics/posture.h"
#include "core/kinematics/solutions.h"
#include "tests/core/kinematics/robots.h"

namespace takt::kinematics {
namespace {

using test::pose_distance;
using test::random_q;

/// A chain of six revolute joints with any axes.
Chain random_six(Random& random) {
  RobotModel model = test::random_model(random, 6);
  for (Joint& joint : model.joints) {
    if (joint.type == JointType::kPrismatic || joint.type == JointType::kContinuous) joint.type = JointType::kRevolute;
    joint.lower = -3.14;
    joint.upper = 3.14;
  }
  return *Chain::create(model, "l0", "flange");
}

struct Tally {
  int poses = 0, missed = 0;
  std::size_t solutions = 0, most = 0;
};

/// Random poses outside of singular postures: whether the joints that made each are found.
Tally tally(const Chain& chain, const SolutionOptions& options, int rounds, Random& random) {
  Tally tally;
  for (int round = 0; round < rounds; ++round) {
    const JointVector q = random_q(random, chain);
    if (singularity(chain, q).measure < 1e-2) continue;
    SolutionOptions here = options;
    here.turns = false;
    here.reference = q;
    if (chain.joint_count() == 7) here.held_values = {q[here.held_joint]};
    const auto found = inverse_solutions(chain, chain.forward(q), here);
    for (const JointVector& s : found) EXPECT_LT(pose_distance(chain.forward(s), chain.forward(q)), 1e-9);
    ++tally.poses;
    if (found.empty() || (found.front() - q).cwiseAbs().maxCoeff() > 1e-6) ++tally.missed;
    tally.solutions += found.size();
    tally.most = std::max(tally.most, found.size());
  }
  return tally;
}

TEST(Elimination, ArmsWithoutAnyRegularity) {
  Random random(31, "any six");
  Tally all;
  for (int arm = 0; arm < 30; ++arm) {
    const Tally here = tally(random_six(random), {}, 60, random);
    all.poses += here.poses;
    all.missed += here.missed;
    all.solutions += here.solutions;
    all.most = std::max(all.most, here.most);
  }
  EXPECT_GT(all.poses, 1000);
  EXPECT_EQ(all.missed, 0);
  EXPECT_GE(all.most, 6u);
  RecordProperty("solutions", static_cast<int>(all.solutions));
}

TEST(Elimination, ForeignArmsWithoutAClosedForm) {
  Random random(32, "foreign");
  for (const test::ForeignArm& arm : test::foreign_arms()) {
    if (!arm.family.empty()) continue;
    SCOPED_TRACE(arm.name);
    SolutionOptions options;
    if (!arm.held.empty()) options.held_joint = arm.held.front();
    const Tally here = tally(test::chain_of(arm.urdf), options, 600, random);
    EXPECT_GT(here.poses, 300);
    EXPECT_EQ(here.missed, 0);
  }
}

}  // namespace
}  // namespace takt::kinematics
