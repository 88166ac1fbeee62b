#include "core/device/guard.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/device/brake_ramp.h"

namespace takt::device {
namespace {

using Rule = Violation::Rule;
constexpr double kPeriod = 1e-3;

motion::JointLimits limits_of(int n) {
  return {.lower = JointVector::Constant(n, -2.0),
          .upper = JointVector::Constant(n, 2.0),
          .velocity = JointVector::Constant(n, 1.5),
          .acceleration = JointVector::Constant(n, 8.0),
          .jerk = JointVector::Constant(n, 160.0)};
}

ArmSetPoint at(double q, double dq = 0.0, double ddq = 0.0, int n = 3) {
  return {.cycle = 0,
          .stamp = 0,
          .q = JointVector::Constant(n, q),
          .dq = JointVector::Constant(n, dq),
          .ddq = JointVector::Constant(n, ddq)};
}

class GuardTest : public testing::Test {
 protected:
  void SetUp() override { guard_.rest_at(JointVector::Zero(3)); }
  /// Feeds a motion of constant jerk until it has the asked acceleration.
  void accelerate_to(double a, double jerk) {
    const int cycles = static_cast<int>(std::lround(a / (jerk * kPeriod)));
    for (int k = 1; k <= cycles; ++k) {
      const double t = k * kPeriod;
      const auto next = at(jerk * t * t * t / 6, jerk * t * t / 2, jerk * t);
      ASSERT_FALSE(guard_.check(next)) << k;
      guard_.sent(next);
    }
  }
  Guard guard_{limits_of(3), kPeriod};
};

/// A base that cannot go sideways: an arc with its tangent passes, the same arc with a heading that is behind does not.
TEST(RollingGuard, S2_NothingThatGoesSidewaysPasses) {
  motion::JointLimits limits = limits_of(3);
  limits.nonholonomic = true;
  for (const double behind : {0.0, 0.02}) {
    Guard guard(limits, kPeriod);
    guard.rest_at(JointVector::Zero(3));
    std::optional<Violation> violation;
    for (int k = 1; k <= 400 && !violation; ++k) {
      // From rest along a circle of 1 m to the left; `behind` is the share of the turn that the heading lacks.
      const double t = k * kPeriod, jerk = 4.0;
      const double s = jerk * t * t * t / 6, ds = jerk * t * t / 2, dds = jerk * t;
      const double turn = 1.0 - behind;
      ArmSetPoint next = at(0.0);
      next.q << std::sin(s), 1.0 - std::cos(s), turn * s;
      next.dq << std::cos(s) * ds, std::sin(s) * ds, turn * ds;
      next.ddq << std::cos(s) * dds - std::sin(s) * ds * ds, std::sin(s) * dds + std::cos(s) * ds * ds, turn * dds;
      violation = guard.check(next);
      guard.sent(next);
    }
    EXPECT_EQ(violation.has_value(), behind > 0.0);
    if (violation) {
      EXPECT_EQ(violation->rule, Rule::kSideways);
    }
  }
}

TEST_F(GuardTest, S2_NothingThatIsNotFinitePasses) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  for (const double bad : {kNan, kInf, -kInf})
    for (int part = 0; part < 3; ++part)
      for (int joint = 0; joint < 3; ++joint) {
        ArmSetPoint next = at(0.0);
        (part == 0 ? next.q : part == 1 ? next.dq : next.ddq)[joint] = bad;
        const auto violation = guard_.check(next);
        ASSERT_TRUE(violation);
        EXPECT_EQ(violation->rule, Rule::kNotFinite);
        EXPECT_EQ(violation->joint, joint);
      }
}

TEST_F(GuardTest, S2_EachLimitTripsByItsName) {
  EXPECT_EQ(guard_.check(at(0.01))->rule, Rule::kVelocity);      // 10 rad/s
  EXPECT_EQ(guard_.check(at(1e-4))->rule, Rule::kAcceleration);  // 100 rad/s^2
  EXPECT_EQ(guard_.check(at(2e-6))->rule, Rule::kJerk);          // 2000 rad/s^3
  EXPECT_EQ(guard_.check(at(0.0, 0.001))->rule, Rule::kInconsistent);
  guard_.rest_at(JointVector::Constant(3, 1.9999999));
  const auto outside = guard_.check(at(2.0000001));
  ASSERT_TRUE(outside);
  EXPECT_EQ(outside->rule, Rule::kPosition);
  EXPECT_EQ(outside->limit, 2.0);
  EXPECT_EQ(guard_.check(at(2.0, 0.0, 0.0, 2))->rule, Rule::kSize);
}

/// What cannot be stopped any more does not pass, although it is still inside every limit.
TEST_F(GuardTest, S2_WhatCannotBeStoppedInsideTripsBefore) {
  for (int k = 0; k < 4000; ++k) {
    const double t = (k + 1) * kPeriod, ramp = std::min(t, 0.05), a = 160.0 * ramp;
    // 0.05 s of jerk, then constant acceleration: towards 1.5 rad/s and beyond.
    const double late = t - ramp, v = 80.0 * ramp * ramp + a * late;
    const auto next = at(160.0 / 6 * ramp * ramp * ramp + 80.0 * ramp * ramp * late + a * late * late / 2, v, a);
    const auto violation = guard_.check(next);
    if (violation) {
      EXPECT_EQ(violation->rule, Rule::kVelocity);
      EXPECT_NEAR(v, 1.5 - 8.0 * 8.0 / 320.0, 0.02);
      return;
    }
    guard_.sent(next);
  }
  FAIL();
}

/// An arm outside of its range (a stop may end 0.1 mrad beyond, a hand may push it) is not lost: it may stand, and move
/// back. It may not go further out.
TEST_F(GuardTest, S2_FromOutsideOfTheRangeTheOnlyWayIsBack) {
  for (const double outside : {2.00007, 2.3, -2.00007, -2.3}) {
    guard_.rest_at(JointVector::Constant(3, outside));
    EXPECT_FALSE(guard_.check(at(outside))) << outside;
    const double jerk = 160.0, h = kPeriod, away = std::copysign(1.0, outside);
    const auto moved = [&](double sign) {
      return at(outside + sign * jerk * h * h * h / 6, sign * jerk * h * h / 2, sign * jerk * h);
    };
    const auto further = guard_.check(moved(away));
    ASSERT_TRUE(further) << outside;
    EXPECT_EQ(further->rule, Rule::kPosition);
    EXPECT_FALSE(guard_.check(moved(-away))) << outside;
  }
}

TEST_F(GuardTest, NamesJointValueAndLimit) {
  const auto violation = guard_.check(at(0.01));
  ASSERT_TRUE(violation);
  EXPECT_EQ(describe(*violation, {"a1", "a2", "e1"}).view(), "joint a1: velocity 10 beyond 1.5 rad/s");
}

TEST_F(GuardTest, AMotionAtItsLimitsPasses) { accelerate_to(8.0, 160.0); }

TEST_F(GuardTest, ARampFromThereToRestPasses) {
  accelerate_to(8.0, 160.0);
  const auto& last = guard_.last();
  const BrakeRamp ramp({last.q, last.dq, last.ddq}, guard_.limits());
  for (int k = 1; k <= 500; ++k) {
    const auto sample = ramp.sample(k * kPeriod);
    const ArmSetPoint next{.cycle = k, .stamp = 0, .q = sample.q, .dq = sample.dq, .ddq = sample.ddq};
    const auto violation = guard_.check(next);
    ASSERT_FALSE(violation) << k << " " << describe(*violation, {}).view();
    guard_.sent(next);
  }
  EXPECT_TRUE(guard_.at_rest());
}

/// Behind the guard nothing exceeds a limit: random motions, most of them wild; what the guard refuses is replaced by
/// the ramp. An oracle of its own differentiates what was sent.
TEST(Guard, S2_BehindItNoLimitIsExceeded) {
  Random random(21);
  const auto limits = limits_of(2);
  int trips = 0;
  for (int run = 0; run < 300; ++run) {
    Guard guard(limits, kPeriod);
    JointVector q = JointVector::Zero(2);
    for (int i = 0; i < 2; ++i) q[i] = random.uniform(-1.5, 1.5);
    guard.rest_at(q);
    std::vector<JointVector> sent(4, q);
    double jerk[2] = {0, 0}, v[2] = {0, 0}, a[2] = {0, 0};
    int braking = -1;
    BrakeRamp ramp;
    const double wildness = random.uniform(0.2, 3.0);
    for (int k = 0; k < 600; ++k) {
      ArmSetPoint next = guard.last();
      if (k % 20 == 0)
        for (double& j : jerk) j = wildness * random.uniform(-160.0, 160.0);
      for (int i = 0; i < 2; ++i) {
        next.q[i] += kPeriod * (v[i] + kPeriod * (a[i] / 2 + kPeriod * jerk[i] / 6));
        next.dq[i] = v[i] += kPeriod * (a[i] + kPeriod * jerk[i] / 2);
        next.ddq[i] = a[i] += kPeriod * jerk[i];
      }
      if (random.unit() < 1e-3) next.q[0] += random.uniform(-1.0, 1.0);
      if (random.unit() < 1e-4) next.dq[1] = std::numeric_limits<double>::quiet_NaN();
      if (braking < 0 && guard.check(next)) {
        ++trips;
        ramp = BrakeRamp({guard.last().q, guard.last().dq, guard.last().ddq}, limits);
        braking = 0;
      }
      if (braking >= 0) {
        const auto sample = ramp.sample(++braking * kPeriod);
        next.q = sample.q, next.dq = sample.dq, next.ddq = sample.ddq;
      }
      guard.sent(next);
      sent.push_back(next.q);
      const auto n = sent.size();
      for (int i = 0; i < 2; ++i) {
        const double d1 = sent[n - 1][i] - sent[n - 2][i], d2 = d1 - (sent[n - 2][i] - sent[n - 3][i]);
        const double d3 = d2 - (sent[n - 2][i] - 2 * sent[n - 3][i] + sent[n - 4][i]);
        ASSERT_LE(std::abs(sent.back()[i]), 2.0 + 1e-4);
        ASSERT_LE(std::abs(d1), 1.5 * 1.002 * kPeriod);
        ASSERT_LE(std::abs(d2), 8.0 * 1.002 * kPeriod * kPeriod);
        ASSERT_LE(std::abs(d3), 160.0 * 1.01 * kPeriod * kPeriod * kPeriod) << "run " << run << " cycle " << k;
      }
    }
  }
  EXPECT_GT(trips, 100);
}

}  // namespace
}  // namespace takt::device
