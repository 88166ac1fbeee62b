// Two arms that move one frame together: the same law, the same place of the frame, all limits of both.
#include "core/motion/plan_pair.h"
#include "core/motion/path_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/motion/motion_state.h"
#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/random_paths.h"
#include "tests/support/reports.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

namespace robots = kinematics::test;

/// Two arms that hold one thing: the second stands so that its own frame meets the first one's.
struct RandomPair {
  RandomArm first, second;
  JointVector q_first, q_second;
  Eigen::Isometry3d X_FL;

  RandomPair(const std::string& one, const std::string& other, Random& random)
      : first(one, random), second(other, random), q_first(first.good_q(random)), q_second(second.good_q(random)) {
    X_FL = second.chain.forward(q_second) * second.X_FM * (first.chain.forward(q_first) * first.X_FM).inverse();
  }
  [[nodiscard]] ArmPair pair() const { return {first.model(), second.model(), X_FL}; }
};

/// Follows a path with inverse kinematics, as a net does.
JointVector follow_joints(const RandomArm& arm, const Path& path, const PathPoint& at, JointVector q) {
  const PathSample there = sample(path, at);
  EXPECT_TRUE(there.cartesian);
  EXPECT_EQ(arm.inverse.solve(there.frame.X_BM * arm.X_FM.inverse(), there.held.q, q), kinematics::IkStatus::kOk);
  return q;
}

struct Together {
  takt::test::LimitOracle first, second;
  double apart = 0.0;  ///< of the two ways to see C, largest entry of the difference
};

/// Runs both under one clock from `clock` on.
Together run_both(const RandomPair& pair, const PairPlan& plan, PathClock clock, const Targets& targets) {
  Together seen{joint_oracle(pair.first.limits, 1e-11), joint_oracle(pair.second.limits, 1e-11)};
  JointVector q1 = plan.leader.q_start, q2 = plan.follower.q_start;
  for (int cycle = 0; cycle < 30'000 && !clock.at_end(); ++cycle) {
    clock.update(targets(), kPeriod);
    const PathPoint at = follow(plan.leader.law, clock.state());
    q1 = follow_joints(pair.first, plan.leader.path, at, q1);
    q2 = follow_joints(pair.second, plan.follower.path, at, q2);
    seen.first.add(as_list(q1));
    seen.second.add(as_list(q2));
    const Eigen::Isometry3d by_first = pair.X_FL * pair.first.chain.forward(q1) * pair.first.X_FM;
    const Eigen::Isometry3d by_second = pair.second.chain.forward(q2) * pair.second.X_FM;
    seen.apart = std::max(seen.apart, (by_first.matrix() - by_second.matrix()).cwiseAbs().maxCoeff());
  }
  return seen;
}

LegMaker line(const RandomArm& arm, Random& random, const Blend& blend) {
  const Eigen::Isometry3d draw = nearby(random, Eigen::Isometry3d::Identity(), 0.12, 0.3);
  return [&arm, draw, blend](const JointVector& q) {
    auto leg = lin_leg(arm.model(), q, arm.chain.forward(q) * arm.X_FM * draw);
    if (leg) leg->blend = blend;
    return leg;
  };
}

// Relative set points of a jointly held part: equal to the residual of the solver, whatever the clock does.
TEST(PlanPair, P5_BothArmsSeeTheFrameAtTheSamePlaceUnderAnyClockAndKeepTheirLimits) {
  Random random(41);
  const std::vector<std::string> urdfs = {robots::lwr_urdf(), robots::ur5_urdf(), robots::tx90_urdf()};
  int planned = 0, relayed = 0;
  for (int i = 0; i < 45; ++i) {
    SCOPED_TRACE(testing::Message() << "pair " << i);
    const RandomPair pair(urdfs[static_cast<std::size_t>(i) % 3], urdfs[static_cast<std::size_t>(i / 3) % 3], random);
    const Blend blend{Blend::Kind::kFraction, random.uniform(0.1, 0.4)};
    std::vector<LegMaker> makers;
    for (std::size_t k = 0; k < 1 + random.bits() % 2; ++k) makers.push_back(line(pair.first, random, blend));
    const auto plan = plan_pair(pair.pair(), pair.q_first, pair.q_second, makers);
    const LegMaker next = line(pair.first, random, blend);
    const double share = random.uniform(0.2, 0.6);
    if (!plan) continue;
    ++planned;
    for (const bool steady : {true, false}) {
      const Together seen = run_both(pair, *plan, PathClock(plan->leader.clock, plan->leader.law, false),
                                     steady ? always(1.0) : at_random(random, false));
      expect_kept(seen.first, "first");
      expect_kept(seen.second, "second");
      EXPECT_LT(seen.apart, 1e-9);
    }
    const Departure from{.motion = plan->leader,
                         .tau = std::ceil(share * plan->leader.duration() / kPeriod) * kPeriod,
                         .lead = 4e-3,
                         .blend = blend};
    const auto after = plan_pair_take_over(pair.pair(), from, plan->follower, {next});
    if (!after) continue;
    ++relayed;
    const Together seen =
        run_both(pair, *after, PathClock(after->leader.clock, after->leader.law, false, true), always(1.0));
    EXPECT_LT(seen.apart, 1e-9);
    const ArmModel second = pair.second.model();
    const auto was = joints_at(second, plan->follower, from.tau), is = joints_at(second, after->follower, 0.0);
    ASSERT_TRUE(was && is);
    EXPECT_LT((was->q - is->q).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((was->dq - is->dq).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((was->ddq - is->ddq).cwiseAbs().maxCoeff(), 1e-4);
    expect_kept(seen.second, "second, after a blend");
  }
  std::printf("%d of 45 pairs planned, %d taken over in motion\n", planned, relayed);
  EXPECT_GT(planned, 15);
  EXPECT_GT(relayed, 4);
}

TEST(PlanPair, WhatOneOfThemCannotFollowIsSaid) {
  Random random(42);
  RandomPair pair(robots::lwr_urdf(), robots::lwr_urdf(), random);
  const auto far = [&pair](const JointVector& q) {
    Eigen::Isometry3d X = pair.first.chain.forward(q) * pair.first.X_FM;
    X.translation() += 5.0 * Eigen::Vector3d::UnitX();
    return lin_leg(pair.first.model(), q, X);
  };
  EXPECT_THAT(plan_pair(pair.pair(), pair.q_first, pair.q_second, {far}).error(),
              Reports(Code::kUnreachable, "/0/goal"));
  const auto in_joints = [&pair](const JointVector& q) { return ptp_leg(pair.first.model(), q, 0.99 * q); };
  EXPECT_THAT(plan_pair(pair.pair(), pair.q_first, pair.q_second, {in_joints}).error(),
              Reports(Code::kConflict, "/follower"));
}

}  // namespace
}  // namespace takt::motion::test
