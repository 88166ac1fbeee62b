#include "core/device/following_monitor.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace takt::device {
namespace {

constexpr Nanoseconds kWindow = 100 * kMillisecond;

JointVector two(double a, double b) {
  JointVector q(2);
  q << a, b;
  return q;
}

/// Set points of a swing; the machine follows with a delay (cycles) and a constant offset (rad) of the second joint.
std::optional<FollowingError> swing(int delay, double offset) {
  FollowingMonitor monitor(0.1, kWindow, kMillisecond);
  const auto at = [](int k) { return two(std::sin(2e-3 * k), 1.2 * std::cos(3e-3 * k)); };
  for (int k = 0; k < 4000; ++k) {
    monitor.sent(at(k));
    if (const auto error = monitor.check(at(std::max(k - delay, 0)) + two(0.0, offset))) return error;
  }
  return std::nullopt;
}

TEST(FollowingMonitor, ADelayWithinTheWindowIsNoError) {
  Random random(1, "following");
  for (int i = 0; i < 50; ++i) {
    const int delay = static_cast<int>(random.uniform(0.0, 101.0));
    EXPECT_FALSE(swing(delay, random.uniform(-0.099, 0.099))) << delay;
  }
}

TEST(FollowingMonitor, AnOffsetBeyondTheBoundIsOne) {
  for (const double offset : {-0.5, -0.35, 0.35, 0.5}) {
    const auto error = swing(5, offset);
    ASSERT_TRUE(error) << offset;
    EXPECT_EQ(error->joint, 1);
    EXPECT_GT(error->error, 0.1);
    EXPECT_LE(error->error, std::abs(offset) + 1e-12);
  }
}

TEST(FollowingMonitor, AMachineThatStandsStillIsNoticedWithinTheWindowAndTheBound) {
  FollowingMonitor monitor(0.1, kWindow, kMillisecond);
  const double speed = 1.0;  // rad/s
  int noticed = -1;
  for (int k = 0; k < 2000 && noticed < 0; ++k) {
    monitor.sent(two(k < 500 ? 0.0 : 1e-3 * speed * (k - 500), 0.0));
    if (monitor.check(two(0.0, 0.0))) noticed = k;
  }
  EXPECT_GE(noticed, 500 + 100 + 100) << "ms: the bound, then the window";
  EXPECT_LE(noticed, 500 + 100 + 100 + 20) << "the window moves on by blocks";
}

TEST(FollowingMonitor, AJumpIsNoticedAtOnce) {
  FollowingMonitor monitor(0.1, kWindow, kMillisecond);
  for (int k = 0; k < 500; ++k) monitor.sent(two(0.3, 0.4));
  EXPECT_FALSE(monitor.check(two(0.3, 0.4)));
  const auto error = monitor.check(two(0.6, 0.4));
  ASSERT_TRUE(error);
  EXPECT_EQ(error->joint, 0);
  EXPECT_NEAR(error->error, 0.3, 1e-12);
}

TEST(FollowingMonitor, NothingIsJudgedBeforeTheWindowIsFull) {
  FollowingMonitor monitor(0.1, kWindow, kMillisecond);
  for (int k = 0; k < 90; ++k) monitor.sent(two(0.0, 0.0));
  EXPECT_FALSE(monitor.check(two(1.0, 0.0)));
  for (int k = 0; k < 30; ++k) monitor.sent(two(0.0, 0.0));
  EXPECT_TRUE(monitor.check(two(1.0, 0.0)));
  monitor.clear();
  EXPECT_FALSE(monitor.check(two(1.0, 0.0)));
}

}  // namespace
}  // namespace takt::device
