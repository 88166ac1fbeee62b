#include "core/motion/path_clock.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "tests/core/motion/shortest_time.h"
#include "tests/support/reports.h"

namespace takt::motion {
namespace {

using takt::test::Reports;

constexpr double kPeriod = 1e-3;

ClockBounds random_bounds(Random& random) {
  return {.acceleration_max = std::exp(random.uniform(-0.5, 4.0)), .jerk_max = std::exp(random.uniform(0.0, 9.0))};
}

double random_target(Random& random, double lowest) {
  constexpr double kCommon[] = {0.0, 1.0, -1.0, 0.3};
  const double pick = random.unit();
  if (pick < 0.5) return std::max(lowest, kCommon[random.bits() % 4]);
  return random.uniform(lowest, 1.0);
}

/// Runs a clock under random targets that change at any cycle and calls `judge(last, now, target)` after each.
template <class Judge>
void run_randomly(PathClock& clock, Random& random, double lowest, int cycles, const Judge& judge) {
  double target = 1.0;
  int left = 0;
  for (int i = 0; i < cycles; ++i) {
    if (left-- == 0) {
      target = random_target(random, lowest);
      left = static_cast<int>(random.bits() % 400);
    }
    const ClockState last = clock.state();
    clock.update(target, kPeriod);
    judge(last, clock.state(), target);
  }
}

// Row P2: whatever the targets do, the rate keeps its bounds and its range.
TEST(PathClock, P2_RateKeepsItsBoundsForAnyTargets) {
  Random random(11);
  for (int run = 0; run < 60; ++run) {
    const ClockBounds bounds = random_bounds(random);
    const bool retraceable = random.unit() < 0.5;
    PathClock clock(bounds, 1e4, retraceable);
    clock.reset({.tau = 5e3});
    const double lowest = retraceable ? -1.0 : 0.0;
    run_randomly(clock, random, lowest, 5000, [&](const ClockState& last, const ClockState& now, double) {
      EXPECT_GE(now.rate, lowest);
      EXPECT_LE(now.rate, 1.0);
      EXPECT_LE(std::abs(now.rate_change), bounds.acceleration_max * (1 + 1e-9));
      EXPECT_LE(std::abs(now.rate - last.rate) / kPeriod, bounds.acceleration_max * (1 + 1e-9));
      EXPECT_LE(std::abs(now.rate_change - last.rate_change) / kPeriod, bounds.jerk_max * (1 + 1e-6) + 1e-9);
      // What the planner counts on: near full rate there is little change of it (docs/motion.md).
      EXPECT_LE(now.rate_change * now.rate_change, 2 * bounds.jerk_max * (1 - std::abs(now.rate)) + 1e-6);
    });
  }
}

TEST(PathClock, PathTimeIsTheIntegralOfTheRate) {
  Random random(12);
  PathClock clock({.acceleration_max = 8.0, .jerk_max = 60.0}, 1e4, true);
  clock.reset({.tau = 5e3});
  run_randomly(clock, random, -1.0, 20000, [&](const ClockState& last, const ClockState& now, double) {
    // Trapezoid; its error is at most jerk * period^3 / 12, as rate'' is bounded by the jerk.
    EXPECT_NEAR(now.tau - last.tau, kPeriod * (last.rate + now.rate) / 2, 60.0 * 1e-9 / 12 + 2e-12);
  });
}

TEST(PathClock, ReachesEachTargetInTheShortestTimeAndHoldsItExactly) {
  Random random(13);
  for (int run = 0; run < 300; ++run) {
    const ClockBounds bounds = random_bounds(random);
    PathClock clock(bounds, 1e6, true);
    clock.reset({.tau = 5e5});
    run_randomly(clock, random, -1.0, 200, [](const auto&, const auto&, double) {});
    const double target = random_target(random, -1.0);
    const double shortest = test::shortest_time_to_velocity({1.0, bounds.acceleration_max, bounds.jerk_max},
                                                            clock.state().rate, clock.state().rate_change, target);
    const int cycles = static_cast<int>(std::ceil(shortest / kPeriod - 1e-6));
    for (int i = 0; i + 1 < cycles; ++i) clock.update(target, kPeriod);
    if (cycles > 1) {
      EXPECT_FALSE(clock.state().rate == target && clock.state().rate_change == 0.0) << "faster than can be";
    }
    clock.update(target, kPeriod);
    clock.update(target, kPeriod);
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(clock.state().rate, target) << "run " << run;
      EXPECT_EQ(clock.state().rate_change, 0.0);
      clock.update(target, kPeriod);
    }
  }
}

TEST(PathClock, DoesNotOvershootATargetThatItReachesFromRest) {
  for (const double target : {0.0, 0.37, 0.99, 1.0}) {
    PathClock clock({.acceleration_max = 5.0, .jerk_max = 100.0}, 1e3, true);
    clock.reset({.tau = 500, .rate = 0.6});
    const bool rises = target > 0.6;
    for (int i = 0; i < 2000; ++i) {
      clock.update(target, kPeriod);
      EXPECT_TRUE(rises ? clock.state().rate <= target : clock.state().rate >= target);
    }
  }
}

// Row L6: the bound on the time of a stop.
TEST(PathClock, L6_StopTimeBoundHoldsAndIsNotIdle) {
  Random random(14);
  double longest_share = 0.0;
  for (int run = 0; run < 400; ++run) {
    const ClockBounds bounds = random_bounds(random);
    const bool retraceable = random.unit() < 0.5;
    PathClock clock(bounds, 1e6, retraceable);
    clock.reset({.tau = 5e5});
    const double lowest = retraceable ? -1.0 : 0.0;
    run_randomly(clock, random, lowest, static_cast<int>(random.bits() % 2000),
                 [](const auto&, const auto&, double) {});
    double time = 0.0;
    while (!clock.at_rest() && time < 100.0) {
      clock.update(0.0, kPeriod);
      time += kPeriod;
    }
    EXPECT_LE(time, clock.stop_time_bound() + 1.01 * kPeriod);
    longest_share = std::max(longest_share, time / (clock.stop_time_bound() + kPeriod));
  }
  EXPECT_GT(longest_share, 0.8) << "a bound that nothing comes near says little";
}

TEST(PathClock, StartsAtItsTargetAndEndsExactlyAtTheEnds) {
  PathClock clock({.acceleration_max = 2.0, .jerk_max = 10.0}, 0.1, true);
  EXPECT_TRUE(clock.at_start());
  EXPECT_TRUE(clock.at_rest());
  clock.update(1.0, kPeriod);
  EXPECT_DOUBLE_EQ(clock.state().tau, kPeriod) << "the law is at rest at its start: no ramp of the rate";
  for (int i = 0; i < 120; ++i) clock.update(1.0, kPeriod);
  EXPECT_EQ(clock.state().tau, 0.1);
  EXPECT_TRUE(clock.at_end());
  EXPECT_TRUE(clock.at_rest());
  for (int i = 0; i < 120; ++i) clock.update(-1.0, kPeriod);
  EXPECT_EQ(clock.state().tau, 0.0);
  EXPECT_TRUE(clock.at_rest());
  clock.update(-1.0, kPeriod);
  EXPECT_EQ(clock.state().tau, 0.0);
}

// A clock that takes another one over goes on as that one would have, whatever it was doing.
TEST(PathClock, P2_AClockInMotionTakesAnotherOneOver) {
  Random random(13);
  for (int run = 0; run < 200; ++run) {
    const ClockBounds bounds = random_bounds(random);
    PathClock clock(bounds, 10.0, false);
    run_randomly(clock, random, 0.0, 10 + static_cast<int>(random.bits() % 800), [](auto&&...) {});
    const ClockState here = clock.state();
    if (here.tau == 0.0) continue;  // it has not begun: the law is at rest there
    PathClock next(bounds, 10.0 - here.tau, false, true);
    next.reset({.tau = 0.0, .rate = here.rate, .rate_change = here.rate_change});
    for (int i = 0; i < 300; ++i) {
      const double target = i < 200 ? 0.0 : 1.0;
      clock.update(target, kPeriod);
      next.update(target, kPeriod);
      ASSERT_NEAR(next.state().tau + here.tau, clock.state().tau, 1e-12) << "run " << run << ", cycle " << i;
      ASSERT_NEAR(next.state().rate, clock.state().rate, 1e-12);
    }
  }
}

TEST(PathClock, AClockInMotionBrakesAtItsBeginAndNeverJumps) {
  PathClock clock({.acceleration_max = 2.0, .jerk_max = 10.0}, 1.0, true, true);
  EXPECT_EQ(clock.state().rate, 1.0);
  clock.update(0.0, kPeriod);
  EXPECT_NEAR(clock.state().rate, 1.0, 1e-5) << "asked to stop in its first cycle";
  for (int i = 0; i < 2'000; ++i) clock.update(-1.0, kPeriod);
  EXPECT_TRUE(clock.at_rest());
  EXPECT_GT(clock.state().tau, 0.0) << "there is no way back";
  PathClock paused({.acceleration_max = 2.0, .jerk_max = 10.0}, 1.0, false, true);
  paused.reset({});
  paused.update(0.0, kPeriod);
  EXPECT_TRUE(paused.at_rest());
  paused.update(1.0, kPeriod);
  EXPECT_LE(paused.state().rate, 10.0 * kPeriod * kPeriod) << "the rate has to rise";
  EXPECT_GT(paused.state().tau, 0.0);
}

TEST(PathClock, OnlyARetraceableClockRunsBackwards) {
  PathClock clock({.acceleration_max = 20.0, .jerk_max = 1000.0}, 10.0, false);
  clock.reset({.tau = 5.0});
  for (int i = 0; i < 1000; ++i) clock.update(-1.0, kPeriod);
  EXPECT_EQ(clock.state().tau, 5.0);
  EXPECT_TRUE(clock.at_rest());
}

TEST(PathClock, ATargetThatIsNoNumberStops) {
  PathClock clock({.acceleration_max = 20.0, .jerk_max = 1000.0}, 10.0, false);
  clock.update(1.0, kPeriod);
  for (int i = 0; i < 1000; ++i) clock.update(std::numeric_limits<double>::quiet_NaN(), kPeriod);
  EXPECT_TRUE(clock.at_rest());
  EXPECT_LT(clock.state().tau, 1.0);
}

TEST(PathClock, AClockWithoutDurationStandsAtBothEnds) {
  PathClock clock({}, 0.0, true);
  for (const double target : {1.0, -1.0, 0.0}) {
    clock.update(target, kPeriod);
    EXPECT_EQ(clock.state().tau, 0.0);
    EXPECT_TRUE(clock.at_start() && clock.at_end() && clock.at_rest());
  }
}

TEST(PathClock, FollowGivesDerivativesByRealTime) {
  const TimeLaw law = TimeLaw::rest_to_rest({1.0, 2.0, 8.0});
  PathClock clock({.acceleration_max = 3.0, .jerk_max = 20.0}, law.duration(), false);
  PathPoint last = follow(law, clock.state());
  for (int i = 0; i < 900; ++i) {
    clock.update(i < 500 ? 1.0 : 0.2, kPeriod);
    const PathPoint now = follow(law, clock.state());
    EXPECT_NEAR((now.s - last.s) / kPeriod, (now.ds + last.ds) / 2, 1e-5);
    EXPECT_NEAR((now.ds - last.ds) / kPeriod, (now.dds + last.dds) / 2, 2e-2);
    last = now;
  }
}

TEST(PathClock, BoundsSurviveJsonAndBadOnesAreRefused) {
  const ClockBounds bounds{.acceleration_max = 1.0 / 3.0, .jerk_max = 17.123456789};
  const auto read = clock_bounds_from_json(nlohmann::ordered_json::parse(to_json(bounds).dump()));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->acceleration_max, bounds.acceleration_max);
  EXPECT_EQ(read->jerk_max, bounds.jerk_max);
  const auto bad =
      clock_bounds_from_json(nlohmann::ordered_json::parse(R"({"acceleration_max": 0, "jerk_maximum": 1})"), "/clock");
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error(), Reports(Code::kOutOfRange, "/clock/acceleration_max"));
  EXPECT_THAT(bad.error(), Reports(Code::kMissing, "/clock", {"jerk_max"}));
  EXPECT_THAT(bad.error(), Reports(Code::kUnknownKey, "/clock/jerk_maximum", {"jerk_maximum"}));
}

TEST(PathClock, CommonBoundsAreTheLesserOnes) {
  const ClockBounds both = common({.acceleration_max = 1, .jerk_max = 20}, {.acceleration_max = 2, .jerk_max = 10});
  EXPECT_EQ(both.acceleration_max, 1.0);
  EXPECT_EQ(both.jerk_max, 10.0);
}

}  // namespace
}  // namespace takt::motion
