// The online generators: limits by differencing what leaves them, targets that change in every cycle, exact ends.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "tests/support/limit_oracle.h"
#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using net::Boolean;
using net::JointArray;
using net::Real;
using Json = nlohmann::ordered_json;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kGeneratorPeriod = 1e-3;

LimitOracle oracle(std::size_t axes, double velocity, double acceleration, double jerk) {
  const auto all = [axes](double value) { return std::vector<double>(axes, value); };
  return LimitOracle({all(-kInfinite), all(kInfinite), all(velocity), all(acceleration), all(jerk)}, kGeneratorPeriod,
                     1e-13);
}

/// A tenth of a per mille: the differences of samples that straddle two profiles carry rounding.
constexpr double kWhole = 1.0 + 1e-4;

TEST(Generator, ReachesItsPositionInTheKnownTime) {
  // From rest, far enough to reach all limits: way / v + v / a + a / j.
  PrimitiveHarness one("JerkLimitedPosition", {{"velocity_max", 0.5}, {"acceleration_max", 2.0}, {"jerk_max", 20.0}});
  one.set("start", 0.0).set("reset", false).set("target_velocity", 0.0).set("target", 1.0);
  const double duration = 1.0 / 0.5 + 0.5 / 2.0 + 2.0 / 20.0;
  one.step();
  EXPECT_NEAR(*one.get<Real>("time_left"), duration - kGeneratorPeriod, 1e-9);
  EXPECT_NEAR(*one.get<Real>("position"), 20.0 * std::pow(kGeneratorPeriod, 3) / 6.0, 1e-15);  // one period has run
  one.step(static_cast<int>(duration / kGeneratorPeriod) - 2);
  EXPECT_EQ(one.get<Boolean>("arrived"), false);
  one.step(3);
  EXPECT_EQ(one.get<Boolean>("arrived"), true);
  EXPECT_EQ(one.get<Real>("position"), 1.0);
  EXPECT_EQ(one.get<Real>("velocity"), 0.0);
  EXPECT_EQ(one.step(100).get<Real>("position"), 1.0);
}

TEST(Generator, KeepsItsLimitsWhateverTheTargetDoes) {
  for (const char* type : {"JerkLimitedPosition", "JerkLimitedVelocity"}) {
    SCOPED_TRACE(type);
    const bool position = std::string(type) == "JerkLimitedPosition";
    Json limits{{"acceleration_max", 2.0}, {"jerk_max", 40.0}};
    if (position) limits["velocity_max"] = 0.5;
    PrimitiveHarness one(type, limits);
    one.set("start", 0.0).set("reset", false);
    if (position) one.set("target_velocity", 0.0);
    Random random(1, type);
    LimitOracle judge = oracle(1, 0.5, 2.0, 40.0);
    double sum = 0.0;
    for (int i = 0; i < 20000; ++i) {
      // Long rests, single changes and stretches in which the target moves in every cycle.
      if (random.unit() < 0.003 || (i / 500) % 3 == 0) one.set("target", random.uniform(-0.5, 0.5));
      one.step();
      ASSERT_FALSE(one.is_null("position")) << i;
      judge.add({*one.get<Real>("position")});
      // The derivatives that it gives are those of the positions.
      sum += kGeneratorPeriod * *one.get<Real>("velocity");
      ASSERT_NEAR(sum, *one.get<Real>("position"), 2e-3) << i;
    }
    EXPECT_LE(judge.velocity.share, kWhole);
    EXPECT_LE(judge.acceleration.share, kWhole);
    EXPECT_LE(judge.jerk.share, kWhole);
    EXPECT_GT(judge.jerk.share, 0.9);  // and uses them
  }
}

TEST(Generator, LimitsMayChangeInEveryCycle) {
  PrimitiveHarness one("JerkLimitedPosition", {{"acceleration_max", 5.0}, {"jerk_max", 100.0}});
  one.set("start", 0.0).set("reset", false).set("target", 2.0).set("target_velocity", 0.0).set("velocity_max", 1.0);
  one.step(600);
  EXPECT_NEAR(*one.get<Real>("velocity"), 1.0, 1e-9);
  one.set("velocity_max", 0.25).step(400);  // it brakes to the lower limit, within acceleration and jerk
  EXPECT_NEAR(*one.get<Real>("velocity"), 0.25, 1e-9);
}

TEST(Generator, PassesATargetWithAVelocity) {
  PrimitiveHarness one("JerkLimitedPosition", {{"velocity_max", 1.0}, {"acceleration_max", 5.0}, {"jerk_max", 100.0}});
  one.set("start", 0.0).set("reset", false).set("target", 1.0).set("target_velocity", 0.5);
  double velocity = 0.0, before = 0.0;
  while (before < 1.0) {
    one.step();
    velocity = *one.get<Real>("velocity");
    before = *one.get<Real>("position");
    ASSERT_LT(one.cycle.index, 5000);
  }
  EXPECT_NEAR(velocity, 0.5, 0.01);
}

TEST(Generator, JointsArriveTogether) {
  const Json seven = {2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0};
  for (const char* how : {"time", "phase"}) {
    SCOPED_TRACE(how);
    PrimitiveHarness arm("JerkLimitedJointPosition", {{"joints", 7},
                                                      {"synchronization", how},
                                                      {"velocity_max", seven},
                                                      {"acceleration_max", seven},
                                                      {"jerk_max", {20, 20, 20, 20, 20, 20, 20}}});
    JointArray start, target;
    start.size = target.size = 7;
    for (std::size_t i = 0; i < 7; ++i) target.value[i] = 0.2 * static_cast<double>(i) - 0.5;
    JointArray at_rest = start;
    arm.set("start", start).set("reset", false).set("target", target).set("target_velocity", at_rest);
    LimitOracle judge = oracle(7, 2.0, 2.0, 20.0);
    std::vector<int> arrived(7, -1);
    for (int k = 0; k < 4000 && arm.step().get<Boolean>("arrived") == false; ++k) {
      const JointArray q = *arm.get<JointArray>("position");
      judge.add(std::vector<double>(q.value.begin(), q.value.begin() + 7));
      for (std::size_t i = 0; i < 7; ++i) {
        if (arrived[i] < 0 && std::abs(q.value[i] - target.value[i]) < 1e-6 * std::abs(target.value[i])) arrived[i] = k;
        if (std::string(how) == "phase") {  // on the straight line
          ASSERT_NEAR(q.value[i] * target.value[6], q.value[6] * target.value[i], 1e-9);
        }
      }
    }
    EXPECT_EQ(arm.get<JointArray>("position")->value, target.value);
    EXPECT_LE(judge.jerk.share, kWhole);
    for (std::size_t i = 1; i < 7; ++i) EXPECT_NEAR(arrived[i], arrived[0], 60) << i;
  }
}

TEST(Generator, WhatItCannotDoIsNull) {
  PrimitiveHarness one("JerkLimitedPosition", {{"acceleration_max", 5.0}, {"jerk_max", 100.0}});
  one.set("start", 0.0).set("reset", false).set("target", 1.0).set("target_velocity", 0.0).set("velocity_max", 1.0);
  EXPECT_FALSE(one.step(100).is_null("position"));
  EXPECT_TRUE(one.set("velocity_max", 0.0).step().is_null("position"));
  EXPECT_TRUE(one.set("velocity_max", 1.0).set("target", 1e12).step().is_null("velocity"));
  EXPECT_TRUE(one.set("target", 1.0).set("target_velocity", 2.0).step().is_null("arrived"));
  one.set("target_velocity", 0.0).step();  // begins anew at `start`, at rest
  EXPECT_NEAR(*one.get<Real>("position"), 100.0 * std::pow(kGeneratorPeriod, 3) / 6.0, 1e-15);
  PrimitiveHarness joints("JerkLimitedJointVelocity",
                          {{"joints", 2}, {"acceleration_max", {1, 1}}, {"jerk_max", {1, 1}}});
  JointArray three;
  three.size = 3;
  EXPECT_TRUE(joints.set("target", three).step().is_null("position"));
  EXPECT_FALSE(
      PrimitiveHarness("JerkLimitedJointVelocity", {{"joints", 13}, {"acceleration_max", {1}}, {"jerk_max", {1}}})
          .ready());
}

}  // namespace
}  // namespace takt::test
