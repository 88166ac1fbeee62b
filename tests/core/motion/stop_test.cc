// Stops on the path: as short as the limits where the arm is allow, and never beyond one.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/motion/path_clock.h"
#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/random_paths.h"
#include "tests/support/reports.h"
#include "tests/support/shortest_stop.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

namespace robots = kinematics::test;

std::string urdf(int i) {
  return i % 3 == 0 ? robots::lwr_urdf() : i % 3 == 1 ? robots::ur5_urdf() : robots::tx90_urdf();
}

std::optional<Motion> planned(const RandomArm& arm, const JointVector& q, const LegMaker& maker) {
  auto plan = plan_sequence(arm.model(), q, {maker});
  if (!plan) return std::nullopt;
  return std::move(plan->motion);
}

/// Where a clock that stops from `from` (path time, at a steady rate) comes to rest.
struct Stopped {
  ClockState at;
  double time = 0.0;
};
Stopped stopped(const Motion& motion, double from, double rate, bool with_table = true) {
  ClockBounds bounds = motion.clock;
  if (!with_table) bounds.stop.clear();
  PathClock clock(bounds, motion.law, false);
  clock.reset({.tau = from, .rate = rate});
  Stopped stop;
  while (!clock.at_rest()) {
    clock.update(0.0, kPeriod);
    stop.time += kPeriod;
  }
  stop.at = clock.state();
  return stop;
}

struct Ratios {
  double most = 0.0, sum = 0.0;
  int count = 0;
  int above = 0;  ///< more than 1.3
  void note(double ratio) {
    most = std::max(most, ratio);
    sum += ratio;
    above += ratio > 1.3;
    ++count;
  }
};

/// Stops of one motion at random moments and overrides, over the least way; with the way of one cycle to both, in which
/// a clock that is asked cannot do anything yet.
void measure(Random& random, const RandomArm& arm, const Motion& motion, Ratios& ratios) {
  const takt::test::ShortestStop shortest(arm.model(), motion);
  if (!shortest.known()) return;
  for (int k = 0; k < 4; ++k) {
    const double from = random.uniform(0.02, 0.98) * motion.duration();
    const double rate = k % 3 == 0 ? 1.0 : random.uniform(0.05, 1.0);
    const double s = motion.law.at(from).s, cycle = motion.law.at(from).ds * rate * kPeriod;
    const Stopped stop = stopped(motion, from, rate), alone = stopped(motion, from, rate, false);
    EXPECT_LE(stop.at.tau, alone.at.tau + 1e-9) << "never longer than by the bounds of the clock alone";
    EXPECT_LE(stop.time, alone.time + kPeriod);
    if (stop.at.tau >= motion.duration()) continue;
    const double least = shortest.from(from, rate).s - s;
    ratios.note((motion.law.at(stop.at.tau).s - s + cycle) / (least + cycle));
  }
}

LegMaker ptp_near(const RandomArm& arm, Random& random) {
  const JointVector way = JointVector::NullaryExpr(arm.limits.jerk.size(), [&] { return random.uniform(-1.0, 1.0); });
  return [&arm, way](const JointVector& q) { return ptp_leg(arm.model(), q, JointVector(q + way)); };
}

// Row P2, and "at any override" of it: wherever on the motion, speeding up and slowing down too.
TEST(Stop, P2_OfAPtpTakesTheWayThatItsLimitsNeed) {
  Random random(81);
  Ratios ratios;
  for (int i = 0; i < 60; ++i) {
    const RandomArm arm(urdf(i), random);
    if (const auto motion = planned(arm, arm.good_q(random), ptp_near(arm, random)))
      measure(random, arm, *motion, ratios);
  }
  EXPECT_GT(ratios.count, 100);
  EXPECT_LT(ratios.most, 1.1) << ratios.sum / ratios.count;
  EXPECT_GE(ratios.sum / ratios.count, 1.0) << "nothing can be shorter";
}

TEST(Stop, P2_OfALinTakesTheWayThatItsLimitsNeed) {
  Random random(82);
  Ratios ratios;
  for (int i = 0; i < 60; ++i) {
    const RandomArm arm(urdf(i), random);
    const JointVector q = arm.good_q(random);
    const auto goal = nearby(random, arm.chain.forward(q) * arm.X_FM, 0.3, 0.6);
    const auto motion = planned(arm, q, [&](const JointVector& at) { return lin_leg(arm.model(), at, goal); });
    if (motion) measure(random, arm, *motion, ratios);
  }
  EXPECT_GT(ratios.count, 100);
  EXPECT_LT(ratios.sum / ratios.count, 1.1);
  // What is left where the stop that must always be there crosses parts of the path that the real one never enters.
  EXPECT_LE(ratios.above, ratios.count / 15) << "of " << ratios.count << ", the longest " << ratios.most;
}

/// Targets that change after a few cycles, mostly between stop and go: stops that are eased and begun again.
Targets nervous(Random& random, bool backwards) {
  struct State {
    double target = 1.0;
    int left = 100;
  };
  return [&random, backwards, state = std::make_shared<State>()] {
    if (state->left-- == 0) {
      const double pick = random.unit();
      state->target = pick < 0.5 ? 0.0 : pick < 0.8 ? 1.0 : random.uniform(backwards ? -1.0 : 0.0, 1.0);
      state->left = static_cast<int>(random.bits() % 60);
    }
    return state->target;
  };
}

/// The joints of a motion under targets, cycle by cycle.
takt::test::LimitOracle judged(const RandomArm& arm, const Motion& motion, const Targets& targets) {
  constexpr double kSampleError = 1e-11;  // what inverse kinematics leaves open
  auto oracle = joint_oracle(arm.limits, kSampleError);
  JointVector q = motion.q_start;
  run(motion, targets, 20000, [&](const PathPoint& at) {
    const PathSample there = sample(motion.path, at);
    if (!there.cartesian) {
      q = there.joints.q;
    } else {
      ASSERT_EQ(arm.inverse.solve(there.frame.X_BM * arm.X_FM.inverse(), there.held.q, q), kinematics::IkStatus::kOk);
    }
    oracle.add(as_list(q));
  });
  return oracle;
}

// Row P1: stops, broken off and begun again at random cycles, on everything that is planned.
TEST(Stop, P1_KeepsEveryLimitHoweverItIsBrokenOffAndBegunAgain) {
  Random random(83);
  int planned = 0;
  double most = 0.0;
  for (int i = 0; i < 60; ++i) {
    const RandomArm arm(urdf(i), random);
    std::vector<LegMaker> makers;
    const auto count = 1 + random.bits() % 3;
    for (std::size_t k = 0; k < count; ++k)
      makers.push_back(random_leg(random, arm, 0.25, {Blend::Kind::kDistance, random.uniform(0.005, 0.1)}));
    const auto plan = plan_sequence(arm.model(), arm.good_q(random), makers);
    if (!plan) continue;
    ++planned;
    for (int k = 0; k < 3; ++k) {
      SCOPED_TRACE(testing::Message() << "motion " << i << ", run " << k);
      const auto oracle = judged(arm, plan->motion, nervous(random, k == 1));
      expect_kept(oracle, "joints");
      most = std::max({most, oracle.acceleration.share, oracle.jerk.share});
    }
  }
  EXPECT_GT(planned, 30);
  EXPECT_GT(most, 0.9) << "what the limits allow is used, not only kept";
}

TEST(Stop, KeepsLimitsInLongerCyclesToo) {
  Random random(84);
  for (int i = 0; i < 40; ++i) {
    const RandomArm arm(urdf(i), random);
    const auto motion = planned(arm, arm.good_q(random), ptp_near(arm, random));
    if (!motion) continue;
    const double period = i % 2 == 0 ? 4e-3 : 8e-3;
    PathClock clock(motion->clock, motion->law, true);
    const auto targets = nervous(random, i % 4 < 2);
    takt::test::LimitOracle oracle({as_list(arm.limits.lower), as_list(arm.limits.upper), as_list(arm.limits.velocity),
                                    as_list(arm.limits.acceleration), as_list(arm.limits.jerk)},
                                   period, 1e-15);
    for (int k = 0; k < 3000 && !clock.at_end(); ++k)
      oracle.add(as_list(sample(motion->path, follow(motion->law, clock.update(targets(), period))).joints.q));
    expect_kept(oracle, "joints");
  }
}

// Row L6, with the law.
TEST(Stop, L6_TheBoundOfTheClockHoldsForStopsOfTheTable) {
  Random random(85);
  for (int i = 0; i < 40; ++i) {
    const RandomArm arm(urdf(i), random);
    const auto motion = planned(arm, arm.good_q(random), random_leg(random, arm, 0.3, {}));
    if (!motion) continue;
    PathClock clock(motion->clock, motion->law, i % 2 == 0);
    const auto targets = nervous(random, i % 2 == 0);
    for (int k = 0; k < 200; ++k) {
      for (int n = static_cast<int>(random.bits() % 100); n >= 0; --n) clock.update(targets(), kPeriod);
      PathClock stopping = clock;
      double time = 0.0;
      for (; !stopping.at_rest() && time < 10.0; time += kPeriod) stopping.update(0.0, kPeriod);
      EXPECT_LE(time, clock.stop_time_bound() + 1.01 * kPeriod) << i << ", " << k;
    }
  }
}

TEST(Stop, OfASlowProbeTakesMilliseconds) {
  Random random(86);
  RandomArm arm(robots::lwr_urdf(), random);
  arm.limits.acceleration.setConstant(50.0);  // so that the frame's limits are those that count
  arm.limits.jerk.setConstant(1e4);
  arm.cartesian.linear_jerk = 100.0;
  const JointVector q = arm.good_q(random);
  const auto down = [&](const JointVector& at) {
    auto leg = lin_leg(arm.model(), at, Eigen::Translation3d(0, 0, -0.02) * (arm.chain.forward(at) * arm.X_FM));
    if (leg) leg->linear_velocity = 0.005;
    return leg;
  };
  const auto motion = planned(arm, q, down);
  ASSERT_TRUE(motion);
  const double least = 2.0 * std::sqrt(0.005 / arm.cartesian.linear_jerk);  // jerk and its opposite
  EXPECT_LE(stopped(*motion, 0.5 * motion->duration(), 1.0).time, 1.05 * least + kPeriod);
}

TEST(Stop, AMotionGoesOnAfterItAndEndsOnItsGoal) {
  Random random(87);
  const RandomArm arm(robots::ur5_urdf(), random);
  const auto motion = planned(arm, arm.good_q(random), ptp_near(arm, random));
  ASSERT_TRUE(motion);
  PathClock clock(motion->clock, motion->law, true);
  const auto cycles = static_cast<int>(0.4 * motion->duration() / kPeriod);
  for (int i = 0; i < cycles; ++i) clock.update(1.0, kPeriod);
  while (!clock.at_rest()) clock.update(0.0, kPeriod);
  const ClockState here = clock.state();
  EXPECT_EQ(here.rate, 0.0);
  EXPECT_LT(here.tau, motion->duration());
  for (int i = 0; i < 100; ++i) EXPECT_EQ(clock.update(0.0, kPeriod).tau, here.tau);
  for (int i = 0; i < 10'000 && !clock.at_end(); ++i) clock.update(1.0, kPeriod);
  EXPECT_EQ(follow(motion->law, clock.state()).s, 1.0);
  for (int i = 0; i < 200; ++i) clock.update(-1.0, kPeriod);
  for (int i = 0; i < 1000 && !clock.at_rest(); ++i) clock.update(0.0, kPeriod);
  EXPECT_TRUE(clock.at_rest()) << "backwards too";
  EXPECT_GT(clock.state().tau, 0.0);
}

TEST(Stop, TheTableOfTwoKeepsBoth) {
  const StopTable a = {{.s_end = 0.5, .deceleration = 4.0, .jerk = 10.0},
                       {.s_end = 1.0, .deceleration = 2.0, .jerk = 30.0}};
  const StopTable b = {{.s_end = 0.25, .deceleration = 3.0, .jerk = 20.0, .jerk_by_cube = 1.0},
                       {.s_end = 1.0, .deceleration = 5.0, .jerk = 20.0}};
  const StopTable both = common(a, b);
  ASSERT_EQ(both.size(), 3U);
  EXPECT_EQ(both[0].s_end, 0.25);
  EXPECT_EQ(both[0].deceleration, 3.0);
  EXPECT_EQ(both[0].jerk_by_cube, 1.0);
  EXPECT_EQ(both[1].deceleration, 4.0);
  EXPECT_EQ(both[1].jerk, 10.0);
  EXPECT_EQ(both[2].s_end, 1.0);
  EXPECT_EQ(both[2].jerk, 20.0);
  EXPECT_TRUE(common(a, {}).empty());
}

TEST(Stop, ATableSurvivesJsonAndABadOneIsRefused) {
  Random random(88);
  const RandomArm arm(robots::tx90_urdf(), random);
  const auto motion = planned(arm, arm.good_q(random), random_leg(random, arm, 0.2, {}));
  ASSERT_TRUE(motion);
  ASSERT_FALSE(motion->clock.stop.empty());
  const auto read = clock_bounds_from_json(nlohmann::ordered_json::parse(to_json(motion->clock).dump()));
  ASSERT_TRUE(read) << read.error().to_string();
  EXPECT_EQ(to_json(*read).dump(), to_json(motion->clock).dump());
  const auto refusal = [](const char* text) {
    const auto bad = stop_table_from_json(nlohmann::ordered_json::parse(text), "/stop");
    return bad ? Diagnostics() : bad.error();
  };
  EXPECT_THAT(refusal("[[1.0, 2.0]]"), Reports(Code::kWrongType, "/stop/0"));
  EXPECT_THAT(refusal("[[0.5, 2, 2, 2, 9, 0, 0]]"), Reports(Code::kOutOfRange, "/stop", {"0.5"}));
  EXPECT_THAT(refusal("[[0.5, 2, 2, 2, 9, 0, 0], [0.4, 2, 2, 2, 9, 0, 0]]"), Reports(Code::kOutOfRange, "/stop/1"));
  EXPECT_THAT(refusal("[[1.0, 2, 2, 2, 0, 0, 0]]"), Reports(Code::kOutOfRange, "/stop/0", {"0"}));
  EXPECT_THAT(refusal("{}"), Reports(Code::kWrongType, "/stop"));
}

}  // namespace
}  // namespace takt::motion::test
