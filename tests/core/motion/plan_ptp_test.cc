#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/motion/planner.h"
#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/shortest_time.h"
#include "tests/support/reports.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

using kinematics::Chain;
namespace robots = kinematics::test;

// Positions of a joint line are exact to the rounding of numbers below 8.
constexpr double kPtpSampleError = 1e-15;

Chain chain_for(Random& random, int i) {
  switch (i % 4) {
    case 0:
      return robots::lwr();
    case 1:
      return robots::chain_of(robots::ur5_urdf());
    case 2:
      return robots::chain_of(robots::tx90_urdf());
    default: {
      const int n = 1 + static_cast<int>(random.bits() % 7);
      return *Chain::create(robots::random_model(random, n), "l0", "l" + std::to_string(n));
    }
  }
}

takt::test::LimitOracle judged(const Motion& motion, const JointLimits& limits, const Targets& targets) {
  auto oracle = joint_oracle(limits, kPtpSampleError);
  run(motion, targets, 20000,
      [&](const PathPoint& at) { oracle.add(as_list(std::get<JointLine>(motion.path).sample(at).q)); });
  return oracle;
}

// Rows P1, P3: an oracle that only sees samples finds no limit exceeded, as planned and whatever the clock is told.
TEST(PlanPtp, P3_KeepsJointLimitsForAnyTargetsOfTheClock) {
  Random random(31);
  double most_acceleration = 0.0;
  double most_jerk = 0.0;
  for (int i = 0; i < 120; ++i) {
    const Chain chain = chain_for(random, i);
    const JointLimits limits = random_limits(random, chain);
    const JointVector q0 = robots::random_q(random, chain);
    const double part = i % 3 == 0 ? 0.02 : 1.0;  // short motions too
    const JointVector q1 = q0 + part * (robots::random_q(random, chain) - q0);
    const auto motion = plan_ptp(chain, limits, q0, q1);
    ASSERT_TRUE(motion) << motion.error().to_string();
    expect_kept(judged(*motion, limits, always(1.0)), "as planned");
    for (int k = 0; k < 4; ++k) {
      const auto oracle = judged(*motion, limits, at_random(random, k % 2 == 1));
      expect_kept(oracle, "under random targets");
      most_acceleration = std::max(most_acceleration, oracle.acceleration.share);
      most_jerk = std::max(most_jerk, oracle.jerk.share);
    }
  }
  // The clock's share is used, not only kept.
  EXPECT_GT(most_acceleration, 0.85);
  EXPECT_GT(most_jerk, 0.8);
}

TEST(PlanPtp, TheOracleSeesAClockThatIsTooFast) {
  Random random(32);
  int broken = 0;
  for (int i = 0; i < 20; ++i) {
    const Chain chain = robots::lwr();
    const JointLimits limits = random_limits(random, chain);
    auto motion = plan_ptp(chain, limits, robots::random_q(random, chain), robots::random_q(random, chain));
    ASSERT_TRUE(motion);
    motion->clock.acceleration_max *= 1.6;
    motion->clock.jerk_max *= 2.56;
    for (int k = 0; k < 4; ++k) {
      const auto oracle = judged(*motion, limits, at_random(random, false));
      broken += oracle.acceleration.share > 1.0 || oracle.jerk.share > 1.0;
    }
  }
  EXPECT_GT(broken, 10);
}

/// The shortest time any motion could take from q0 to q1 with all limits for itself.
double shortest_time(const JointLimits& limits, const JointVector& q0, const JointVector& q1) {
  double longest = 0.0;
  for (int i = 0; i < q0.size(); ++i) {
    const AxisLimits axis{limits.velocity[i], limits.acceleration[i], limits.jerk[i]};
    longest = std::max(longest, shortest_time(axis, q1[i] - q0[i]));
  }
  return longest;
}

TEST(PlanPtp, TakesAtMostAnEighthLongerThanTheShortestTimeOfItsAxes) {
  Random random(33);
  for (int i = 0; i < 500; ++i) {
    const Chain chain = robots::lwr();
    // Equal ratios of the limits, so that going in proportion costs nothing.
    JointLimits limits = random_limits(random, chain);
    limits.acceleration = limits.velocity * random.uniform(2.0, 8.0);
    limits.jerk = limits.velocity * random.uniform(20.0, 200.0);
    const JointVector q0 = robots::random_q(random, chain);
    const JointVector q1 = robots::random_q(random, chain);
    const auto motion = plan_ptp(chain, limits, q0, q1);
    ASSERT_TRUE(motion);
    const double shortest = shortest_time(limits, q0, q1);
    EXPECT_GE(motion->duration(), shortest * (1 - 1e-9));
    EXPECT_LE(motion->duration(), shortest * 1.127);
  }
}

TEST(PlanPtp, StartsAndEndsExactlyAtRest) {
  Random random(34);
  const Chain chain = robots::lwr();
  const JointVector q0 = robots::random_q(random, chain);
  const JointVector q1 = robots::random_q(random, chain);
  const auto motion = plan_ptp(chain, random_limits(random, chain), q0, q1);
  ASSERT_TRUE(motion);
  const auto& line = std::get<JointLine>(motion->path);
  const JointSample start = line.sample(follow(motion->law, {.tau = 0.0, .rate = 1.0}));
  const JointSample end = line.sample(follow(motion->law, {.tau = motion->duration(), .rate = 1.0}));
  EXPECT_EQ(start.q, q0);
  EXPECT_EQ(end.q, q1);
  EXPECT_TRUE(start.dq.isZero(0.0) && start.ddq.isZero(0.0) && end.dq.isZero(0.0) && end.ddq.isZero(0.0));
}

TEST(PlanPtp, SharesSlowAMotionDown) {
  Random random(35);
  const Chain chain = robots::lwr();
  const JointLimits limits = random_limits(random, chain);
  const JointVector q0 = JointVector::Zero(7);
  const JointVector q1 = JointVector::Constant(7, 1.5);
  const double full = plan_ptp(chain, limits, q0, q1)->duration();
  const double tenth = plan_ptp(chain, limits, q0, q1, {.velocity = 0.1})->duration();
  EXPECT_GT(tenth, 1.5 / (0.1 * limits.velocity.minCoeff()));
  EXPECT_GT(plan_ptp(chain, limits, q0, q1, {.acceleration = 0.1})->duration(), full);
}

TEST(PlanPtp, AMotionWithoutWayIsLegal) {
  Random random(36);
  const Chain chain = robots::lwr();
  const JointVector q = robots::random_q(random, chain);
  const auto motion = plan_ptp(chain, random_limits(random, chain), q, q);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->duration(), 0.0);
  EXPECT_EQ(std::get<JointLine>(motion->path).sample(follow(motion->law, {})).q, q);
}

TEST(PlanPtp, SmallestWaysHavePlansToo) {
  const Chain chain = robots::lwr();
  Random random(37);
  const JointLimits limits = random_limits(random, chain);
  for (const double way : {1e-13, 1e-11, 1e-9, 1e-6}) {
    const auto motion = plan_ptp(chain, limits, JointVector::Zero(7), JointVector::Constant(7, way));
    ASSERT_TRUE(motion);
    EXPECT_TRUE(std::isfinite(motion->duration()));
    EXPECT_LT(motion->duration(), 0.1);
    expect_kept(judged(*motion, limits, always(1.0)), "a tiny way");
  }
}

TEST(PlanPtp, PlansAreEqualBitForBit) {
  Random random(38);
  const Chain chain = robots::lwr();
  const JointLimits limits = random_limits(random, chain);
  const JointVector q0 = robots::random_q(random, chain);
  const JointVector q1 = robots::random_q(random, chain);
  const auto a = plan_ptp(chain, limits, q0, q1);
  const auto b = plan_ptp(chain, limits, q0, q1);
  EXPECT_EQ(a->duration(), b->duration());
  EXPECT_EQ(a->clock.jerk_max, b->clock.jerk_max);
  EXPECT_EQ(a->law.at(0.1).s, b->law.at(0.1).s);
}

class PlanPtpRefuses : public testing::Test {
 protected:
  Diagnostics refusal(const JointVector& q0, const JointVector& q1, const MotionOptions& options = {}) const {
    const auto motion = plan_ptp(chain_, limits_, q0, q1, options);
    return motion ? Diagnostics() : motion.error();
  }
  Chain chain_ = robots::lwr();
  Random random_{39};
  JointLimits limits_ = random_limits(random_, chain_);
  JointVector zero_ = JointVector::Zero(7);
};

TEST_F(PlanPtpRefuses, GoalsOutsideTheRangeWithJointValueAndRange) {
  JointVector goal = zero_;
  goal[1] = 2.5;
  goal[3] = -3.0;
  const Diagnostics text = refusal(zero_, goal);
  EXPECT_THAT(text, Reports(Code::kOutOfRange, "/goal/1", {"joint_2", "143.239", "-120", "120"}));
  EXPECT_THAT(text, Reports(Code::kOutOfRange, "/goal/3", {"joint_4", "-171.887"})) << "all at once";
  EXPECT_THAT(refusal(goal, zero_), Reports(Code::kOutOfRange, "/start/1"));
}

/// kinematics::kRangeTolerance: a measured start may be outside by what an encoder rounds, a goal by what a file does.
TEST_F(PlanPtpRefuses, StartsAndGoalsAtAnEndOfTheRangeAreNone) {
  const double upper = limits_.upper[0];
  for (const double beyond : {1e-12, 5e-6, 9e-5}) {
    JointVector outside = zero_;
    outside[0] = upper + beyond;
    const auto there = plan_ptp(chain_, limits_, zero_, outside);
    ASSERT_TRUE(there);
    EXPECT_EQ(there->q_goal[0], upper) << "the end itself: the guard lets nothing go further";
    const auto back = plan_ptp(chain_, limits_, outside, zero_);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->q_start, outside) << "where it is";
  }
  JointVector beyond = zero_;
  beyond[0] = upper + 1.1e-4;
  EXPECT_THAT(refusal(zero_, beyond), Reports(Code::kOutOfRange, "/goal/0"));
  EXPECT_THAT(refusal(beyond, zero_), Reports(Code::kOutOfRange, "/start/0"));
}

TEST_F(PlanPtpRefuses, WhatIsNoNumberAndWhatDoesNotFit) {
  JointVector goal = zero_;
  goal[6] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(zero_, goal), Reports(Code::kOutOfRange, "/goal/6", {"joint_7"}));
  EXPECT_THAT(refusal(zero_, JointVector::Zero(6)), Reports(Code::kWrongSize, "/goal", {"6"}));
}

TEST_F(PlanPtpRefuses, BadOptionsAndBadLimits) {
  EXPECT_THAT(refusal(zero_, zero_, {.velocity = 0.0}), Reports(Code::kOutOfRange, "/options/velocity", {"0"}));
  EXPECT_THAT(refusal(zero_, zero_, {.acceleration = 1.5}), Reports(Code::kOutOfRange, "/options/acceleration"));
  limits_.jerk[2] = 0.0;
  limits_.velocity = JointVector::Zero(3);
  EXPECT_THAT(refusal(zero_, zero_), Reports(Code::kOutOfRange, "/limits/jerk/2", {"joint_3"}));
  EXPECT_THAT(refusal(zero_, zero_), Reports(Code::kWrongSize, "/limits/velocity", {"3"}));
}

}  // namespace
}  // namespace takt::motion::test
