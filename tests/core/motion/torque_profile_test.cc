#include "core/motion/torque_profile.h"

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/random_paths.h"
#include "tests/support/reports.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

namespace robots = kinematics::test;

/// Sees nothing but positions once a millisecond, as a torque meter at the joints would.
class TorqueOracle {
 public:
  TorqueOracle(const kinematics::Chain& chain, const DriveLoad& load) : chain_(chain), load_(load) {}

  void add(const JointVector& q) {
    std::swap(q_[0], q_[1]);
    std::swap(q_[1], q_[2]);
    q_[2] = q;
    if (++count_ < 3) return;
    const JointVector dq = (q_[2] - q_[0]) / (2 * kPeriod);
    const JointVector ddq = (q_[2] - 2 * q_[1] + q_[0]) / (kPeriod * kPeriod);
    const JointVector torque = chain_.inverse_dynamics(q_[1], dq, ddq, load_.gravity_B, load_.payload) +
                               load_.armature.cwiseProduct(ddq) + chain_.damping().cwiseProduct(dq) +
                               chain_.friction().cwiseProduct(dq.cwiseSign());
    share = std::max(share, (torque.cwiseAbs().array() / chain_.effort_limit().array()).maxCoeff());
  }

  double share = 0.0;  ///< largest use of a torque limit

 private:
  const kinematics::Chain& chain_;
  const DriveLoad& load_;
  std::array<JointVector, 3> q_;
  int count_ = 0;
};

double share_of_torque(const RandomArm& arm, const DriveLoad& load, const Motion& motion, const Targets& targets) {
  TorqueOracle oracle(arm.chain, load);
  JointVector q = motion.q_start;
  run(motion, targets, 60000, [&](const PathPoint& at) {
    const PathSample there = sample(motion.path, at);
    if (there.cartesian) {
      ASSERT_EQ(arm.inverse.solve(there.frame.X_BM * arm.X_FM.inverse(), there.held.q, q), kinematics::IkStatus::kOk);
    } else {
      q = there.joints.q;
    }
    oracle.add(q);
  });
  return oracle.share;
}

DriveLoad random_load(Random& random, int joints) {
  DriveLoad load{.armature = JointVector(joints)};
  for (Eigen::Index i = 0; i < joints; ++i) load.armature[i] = random.uniform(0.0, 3.0);
  load.payload.mass = random.uniform(0.0, 12.0);
  load.payload.p_FC = {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(0.0, 0.2)};
  load.payload.I_C = 0.02 * Eigen::Matrix3d::Identity();
  return load;
}

std::string some_urdf(int i) {
  return std::array{robots::lwr_urdf(), robots::ur5_urdf(), robots::tx90_urdf()}[static_cast<std::size_t>(i) % 3];
}

// Whatever hangs on the flange and whatever the clock is told: no motor is asked for more than it has. The same motions
// planned without their load ask for more, so the limits were in the way.
TEST(TorqueProfile, P3_RandomSequencesKeepTorqueLimitsForAnyTargets) {
  Random random(91);
  int judged = 0, too_heavy = 0, beyond = 0;
  for (int i = 0; i < 120; ++i) {
    RandomArm arm(some_urdf(i), random);
    arm.limits.acceleration *= 3.0;  // so that motors are what binds
    arm.limits.jerk *= 9.0;
    ArmModel model = arm.model();
    const JointVector q0 = arm.good_q(random);
    std::vector<LegMaker> makers;
    for (std::size_t k = 0; k < 1 + random.bits() % 3; ++k)
      makers.push_back(random_leg(random, arm, 0.25, {Blend::Kind::kFraction, 0.3}));
    const auto light = plan_sequence(model, q0, makers);
    if (!light) continue;
    model.load = random_load(random, arm.chain.joint_count());
    const auto plan = plan_sequence(model, q0, makers);
    if (!plan) {
      EXPECT_THAT(plan.error(), Reports(Code::kLimitExceeded, "/0/goal"));
      ++too_heavy;
      continue;
    }
    ++judged;
    beyond += share_of_torque(arm, *model.load, light->motion, always(1.0)) > 1.0;
    for (int k = 0; k < 3; ++k) {
      const auto targets = k == 0 ? always(1.0) : at_random(random, k == 1);
      EXPECT_LE(share_of_torque(arm, *model.load, plan->motion, targets), 1.0) << "sequence " << i << ", run " << k;
    }
  }
  EXPECT_GT(judged, 40);
  EXPECT_GT(too_heavy, 0);
  EXPECT_GT(beyond, 5);
}

class TorqueOfPtp : public testing::Test {
 protected:
  TorqueOfPtp() : random_(92), arm_(robots::lwr_urdf(), random_) {
    load_.armature = JointVector::Constant(7, 0.5);
    load_.payload = {.mass = 7.0, .p_FC = {0.0, 0.0, 0.08}};
    q_start_ = q_goal_ = JointVector::Zero(7);
    q_start_[3] = 1.5;
    q_goal_[3] = -1.5;
    arm_.limits.acceleration.setConstant(60.0);  // far above what the motors can do
    arm_.limits.jerk.setConstant(3000.0);
  }
  [[nodiscard]] Result<Motion> plan(const std::optional<DriveLoad>& load) const {
    return plan_ptp(arm_.chain, arm_.limits, q_start_, q_goal_, {.load = load});
  }

  Random random_;
  RandomArm arm_;
  DriveLoad load_;
  JointVector q_start_, q_goal_;
};

TEST_F(TorqueOfPtp, TakesWhatTheMotorsHaveAndNotMore) {
  const auto light = plan(std::nullopt), heavy = plan(load_);
  ASSERT_TRUE(light && heavy);
  EXPECT_GT(share_of_torque(arm_, load_, *light, always(1.0)), 1.5);
  const double share = share_of_torque(arm_, load_, *heavy, always(1.0));
  EXPECT_LT(share, 0.95);
  EXPECT_GT(share, 0.75) << "the law has four fifths of what gravity leaves";
  EXPECT_GT(heavy->duration(), light->duration());
}

TEST_F(TorqueOfPtp, NothingChangesWhereTheMotorsHaveMoreThanTheLimitsAllow) {
  arm_.limits.acceleration.setConstant(0.5);
  const auto light = plan(std::nullopt), loaded = plan(load_);
  ASSERT_TRUE(light && loaded);
  EXPECT_EQ(light->duration(), loaded->duration());
  EXPECT_EQ(light->clock.acceleration_max, loaded->clock.acceleration_max);
  EXPECT_EQ(light->clock.jerk_max, loaded->clock.jerk_max);
}

TEST_F(TorqueOfPtp, ALoadThatNobodyCanHoldIsRefusedWithItsTorque) {
  q_goal_[1] = 1.57;  // level
  load_.payload.mass = 60.0;
  const auto motion = plan(load_);
  ASSERT_FALSE(motion);
  const Diagnostics text = motion.error();
  EXPECT_THAT(text, Reports(Code::kLimitExceeded, "/goal", {"60.00", "70", "578.4"}));
}

TEST_F(TorqueOfPtp, HangingFromTheCeilingIsAnotherLoad) {
  load_.payload.mass = 5.0;
  q_start_[1] = q_goal_[1] = 1.2;
  DriveLoad on_the_wall = load_;
  on_the_wall.gravity_B = {-9.81, 0.0, 0.0};
  const auto standing = plan(load_), wall = plan(on_the_wall);
  ASSERT_TRUE(standing && wall);
  EXPECT_NE(standing->duration(), wall->duration());
}

}  // namespace
}  // namespace takt::motion::test
