#include "cell/judge/limit_monitor.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/reports.h"

namespace takt::cell::limit_monitor_test {
namespace {

using kinematics::JointVector;
using takt::test::Names;

constexpr double kPeriod = 1e-3;

JointVector joints(double a, double b) { return (JointVector(2) << a, b).finished(); }

motion::JointLimits limits() {
  return {.lower = joints(-3.0, -1.0),
          .upper = joints(3.0, 2.0),
          .velocity = joints(1.0, 2.0),
          .acceleration = joints(5.0, 10.0),
          .jerk = joints(100.0, 200.0)};
}

/// Joint a1 stands while joint a2 begins at `begin` with speed and acceleration zero and then follows what `jerk` says
/// cycle by cycle, exactly as a third difference sees it.
template <class Jerk>
LimitMonitor moved(double begin, int cycles, const Jerk& jerk) {
  LimitMonitor monitor(limits(), {"a1", "a2"}, kPeriod);
  double position = begin, velocity = 0, acceleration = 0;
  monitor.add(joints(0, position));
  for (int i = 0; i < cycles; ++i) {
    acceleration += jerk(i) * kPeriod;
    velocity += acceleration * kPeriod;
    position += velocity * kPeriod;
    monitor.add(joints(0, position));
  }
  return monitor;
}

/// The jerk with which an acceleration of `a` is reached in 100 cycles, held for `hold` cycles and left again.
double push(int cycle, double a, int hold) {
  if (cycle < 100) return a / 0.1;
  return cycle >= 100 + hold && cycle < 200 + hold ? -a / 0.1 : 0.0;
}

TEST(LimitMonitor, ExactlyAtEachLimitIsHeld) {
  const auto by_jerk = moved(0, 20, [](int) { return 200.0; });
  EXPECT_TRUE(by_jerk.held()) << by_jerk.worst().what;
  EXPECT_NEAR(by_jerk.worst().share, 1.0, 1e-4);
  const auto by_acceleration = moved(0, 180, [](int i) { return push(i, 10.0, 50); });
  EXPECT_TRUE(by_acceleration.held()) << by_acceleration.worst().what;
  EXPECT_NEAR(by_acceleration.worst().share, 1.0, 1e-4);
  const auto by_velocity = moved(0, 300, [](int i) { return push(i, 10.0, 100); });
  EXPECT_TRUE(by_velocity.held()) << by_velocity.worst().what;
  EXPECT_NEAR(by_velocity.worst().share, 1.0, 1e-4);
  LimitMonitor standing(limits(), {"a1", "a2"}, kPeriod);
  standing.add(joints(-3.0, 2.0));
  standing.add(joints(-3.0, 2.0));
  EXPECT_TRUE(standing.held());
  EXPECT_NEAR(standing.worst().share, 1.0, 1e-12);
}

TEST(LimitMonitor, OnePerCentOverAnyLimitIsCaughtAndNamed) {
  const auto jerk = moved(0, 20, [](int) { return -202.0; });
  EXPECT_FALSE(jerk.held());
  EXPECT_THAT(jerk.worst().what, Names("jerk", "a2", "-202", "200"));
  EXPECT_NEAR(jerk.worst().share, 1.01, 1e-3);
  const auto acceleration = moved(0, 180, [](int i) { return push(i, 10.1, 50); });
  EXPECT_FALSE(acceleration.held());
  EXPECT_THAT(acceleration.worst().what, Names("acceleration", "a2", "10.1", "10"));
  const auto velocity = moved(0, 300, [](int i) { return push(i, 10.0, 102); });
  EXPECT_FALSE(velocity.held());
  EXPECT_THAT(velocity.worst().what, Names("velocity", "a2", "2.02", "2"));
  LimitMonitor position(limits(), {"a1", "a2"}, kPeriod);
  position.add(joints(0, -1.015));  // 1 % of half of [-1, 2]
  EXPECT_FALSE(position.held());
  EXPECT_THAT(position.worst().what, Names("position", "a2", "-1.515", "1.5", "0"));
}

TEST(LimitMonitor, TheFirstMotionStartsFromRest) {
  LimitMonitor monitor(limits(), {"a1", "a2"}, kPeriod);
  monitor.add(joints(0, 0));
  monitor.add(joints(0.5e-3, 0));  // half of the velocity limit in one cycle
  EXPECT_FALSE(monitor.held()) << "but 100 times the acceleration";
}

TEST(LimitMonitor, WhatIsNotANumberIsNeverForgotten) {
  LimitMonitor monitor(limits(), {"a1", "a2"}, kPeriod);
  monitor.add(joints(0, 0));
  monitor.add(joints(0, std::numeric_limits<double>::quiet_NaN()));
  for (int i = 0; i < 10; ++i) monitor.add(joints(0, 0));
  EXPECT_FALSE(monitor.held());
  EXPECT_TRUE(std::isnan(monitor.worst().share));
}

TEST(LimitMonitor, WithoutSamplesNothingIsBroken) {
  const LimitMonitor monitor(limits(), {"a1", "a2"}, kPeriod);
  EXPECT_TRUE(monitor.held());
  EXPECT_EQ(monitor.worst().what, "");
}

TEST(LimitMonitor, TorquesCountAgainstWhatTheMotorsHave) {
  LimitMonitor monitor(limits(), {"a1", "a2"}, kPeriod, joints(100.0, 20.0));
  monitor.add(joints(0, 0));
  monitor.add_torque(joints(50.0, -19.0));
  EXPECT_TRUE(monitor.held());
  EXPECT_THAT(monitor.worst().what, Names("torque", "a2", "-19", "20"));
  monitor.add_torque(joints(0.0, 20.1));
  EXPECT_FALSE(monitor.held());
}

TEST(LimitMonitor, ARestartBeginsANewMotion) {
  LimitMonitor monitor(limits(), {"a1", "a2"}, kPeriod);
  monitor.add(joints(0, 0));
  monitor.restart();
  monitor.add(joints(0.1, 0));
  EXPECT_TRUE(monitor.held()) << "no jump: the arm was taken over there";
  monitor.add(joints(0.2, 0));
  EXPECT_FALSE(monitor.held());
}

}  // namespace
}  // namespace takt::cell::limit_monitor_test
