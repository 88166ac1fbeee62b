#include "core/device/brake_ramp.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace takt::device {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

motion::JointLimits random_limits(Random& random, int n) {
  motion::JointLimits limits;
  for (JointVector* v : {&limits.lower, &limits.upper, &limits.velocity, &limits.acceleration, &limits.jerk})
    v->resize(n);
  for (int i = 0; i < n; ++i) {
    limits.lower[i] = -kInfinity;
    limits.upper[i] = kInfinity;
    limits.velocity[i] = random.uniform(0.2, 4.0);
    limits.acceleration[i] = random.uniform(1.0, 20.0);
    limits.jerk[i] = random.uniform(20.0, 1000.0);
  }
  return limits;
}

/// Any state that can be kept within the limits at all.
motion::JointSample random_state(Random& random, const motion::JointLimits& limits) {
  const auto n = limits.velocity.size();
  motion::JointSample state{JointVector::Zero(n), JointVector::Zero(n), JointVector::Zero(n)};
  for (int i = 0; i < n; ++i) {
    state.q[i] = random.uniform(-3.0, 3.0);
    const double v_max = limits.velocity[i];
    const double a_viable = std::min(limits.acceleration[i], std::sqrt(4.0 * v_max * limits.jerk[i]));
    const double a = random.uniform(-a_viable, a_viable), gained = a * std::abs(a) / (2.0 * limits.jerk[i]);
    state.ddq[i] = a;
    state.dq[i] = random.uniform(std::max(-v_max, -v_max - gained), std::min(v_max, v_max - gained));
    if (random.unit() < 0.1) state.dq[i] = state.ddq[i] = 0.0;
  }
  return state;
}

/// Row S2: from a million random axis states every sample keeps the limits, begins where the arm is and ends at rest.
TEST(BrakeRamp, S2_KeepsEveryLimitFromAnyState) {
  Random random(11);
  constexpr int kJoints = 7, kStates = 150'000;  // 1 050 000 axes
  for (int k = 0; k < kStates; ++k) {
    const auto limits = random_limits(random, kJoints);
    const auto state = random_state(random, limits);
    const BrakeRamp ramp(state, limits);
    const double T = ramp.duration();
    const auto start = ramp.sample(0.0);
    const auto end = ramp.sample(T);
    motion::JointSample before = start;
    double t_before = 0.0;
    for (const double share : {0.07, 0.21, 0.34, 0.5, 0.66, 0.83, 0.97, 1.0}) {
      const double t = share * T;
      const auto now = ramp.sample(t);
      for (int i = 0; i < kJoints; ++i) {
        const double h = t - t_before, j = limits.jerk[i];
        ASSERT_LE(std::abs(now.dq[i]), limits.velocity[i] * (1 + 1e-9)) << k << " joint " << i;
        ASSERT_LE(std::abs(now.ddq[i]), limits.acceleration[i] * (1 + 1e-9)) << k << " joint " << i;
        ASSERT_LE(std::abs(now.ddq[i] - before.ddq[i]), j * h * (1 + 1e-6) + 1e-9) << k << " joint " << i;
        // One motion: the trapezoidal rule leaves open what its error term says.
        ASSERT_LE(std::abs(now.dq[i] - before.dq[i] - h / 2 * (now.ddq[i] + before.ddq[i])), j * h * h / 4 + 1e-9);
        ASSERT_LE(std::abs(now.q[i] - before.q[i] - h / 2 * (now.dq[i] + before.dq[i])), j * h * h * h / 12 + 1e-9);
      }
      before = now;
      t_before = t;
    }
    for (int i = 0; i < kJoints; ++i) {
      if (T > 0.0) {
        ASSERT_EQ(start.q[i], state.q[i]);
        ASSERT_EQ(start.dq[i], state.dq[i]);
        ASSERT_EQ(start.ddq[i], state.ddq[i]);
      }
      ASSERT_EQ(end.dq[i], 0.0);
      ASSERT_EQ(end.ddq[i], 0.0);
    }
  }
}

/// All axes come to rest at the same instant, whatever each of them could do alone.
TEST(BrakeRamp, S2_AxesStopTogether) {
  Random random(5);
  for (int k = 0; k < 2000; ++k) {
    const auto limits = random_limits(random, 4);
    auto state = random_state(random, limits);
    for (int i = 0; i < 4; ++i) {
      state.ddq[i] = 0.0;
      state.dq[i] = limits.velocity[i] * (0.3 + 0.1 * i);
    }
    const BrakeRamp ramp(state, limits);
    const auto late = ramp.sample(0.999 * ramp.duration());
    for (int i = 0; i < 4; ++i) EXPECT_GT(std::abs(late.dq[i]), 0.0);
  }
}

/// Straight from constant velocity: the textbook distance v^2 / (2 a) + v a / (2 j).
TEST(BrakeRamp, TextbookDistance) {
  motion::JointLimits limits;
  for (JointVector* v : {&limits.lower, &limits.upper, &limits.velocity, &limits.acceleration, &limits.jerk})
    v->resize(1);
  limits.lower << -10;
  limits.upper << 10;
  limits.velocity << 2;
  limits.acceleration << 5;
  limits.jerk << 50;
  motion::JointSample state{JointVector::Zero(1), JointVector::Constant(1, 2.0), JointVector::Zero(1)};
  const BrakeRamp ramp(state, limits);
  EXPECT_NEAR(ramp.duration(), 2.0 / 5 + 5.0 / 50, 1e-12);
  EXPECT_NEAR(ramp.sample(9.0).q[0], 4.0 / 10 + 2.0 * 5 / 100, 1e-12);
}

/// An axis that would run out of its range while it waits for a slower one brakes alone.
TEST(BrakeRamp, RangeComesBeforeTogether) {
  motion::JointLimits limits;
  for (JointVector* v : {&limits.lower, &limits.upper, &limits.velocity, &limits.acceleration, &limits.jerk})
    v->resize(2);
  limits.lower << -10, -10;
  limits.upper << 0.3, 10;
  limits.velocity << 2, 2;
  limits.acceleration << 10, 1;
  limits.jerk << 1000, 10;
  motion::JointSample state{JointVector::Zero(2), JointVector::Constant(2, 1.0), JointVector::Zero(2)};
  const BrakeRamp ramp(state, limits);
  EXPECT_LE(ramp.sample(ramp.duration()).q[0], 0.3);
  EXPECT_EQ(ramp.sample(0.5 * ramp.duration()).dq[0], 0.0);
  EXPECT_GT(ramp.sample(0.5 * ramp.duration()).dq[1], 0.0);
}

/// After the end the same bits for ever (row L5).
TEST(BrakeRamp, L5_FrozenAfterTheEnd) {
  Random random(3);
  const auto limits = random_limits(random, 5);
  const BrakeRamp ramp(random_state(random, limits), limits);
  const auto end = ramp.sample(ramp.duration());
  for (const double later : {1e-3, 0.5, 1e6}) EXPECT_EQ(ramp.sample(ramp.duration() + later).q, end.q);
}

}  // namespace
}  // namespace takt::device
