// Resampling of set points to a device's instants (row T3).
#include <algorithm>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/device/set_point_series.h"
#include "core/motion/time_law.h"

namespace takt::device {
namespace {

using motion::JointSample;

JointSample state(double q, double dq, double ddq) {
  return {JointVector::Constant(1, q), JointVector::Constant(1, dq), JointVector::Constant(1, ddq)};
}

/// Rest to rest over 1 rad at 80 % of what a slow joint may do, as the path clock's law gives it.
const motion::TimeLaw& law() {
  static const auto made = motion::TimeLaw::rest_to_rest({.velocity = 1.2, .acceleration = 4.0, .jerk = 100.0});
  return made;
}

JointSample ideal(double time) {
  const auto at = law().at(std::clamp(time, 0.0, law().duration()));
  return state(at.s, at.ds, at.dds);
}

void fill(SetPointSeries& series, Nanoseconds period, Nanoseconds end) {
  for (Nanoseconds t = 0; t <= end; t += period) {
    const JointSample s = ideal(to_seconds(t));
    series.add({.cycle = t / period, .stamp = t, .q = s.q, .dq = s.dq, .ddq = s.ddq});
  }
}

TEST(Interpolate, T3_EndsAreMetBitForBitAndRestStaysRest) {
  const JointSample a = state(0.1234567890123, 0.2, -0.3), b = state(0.1236, 0.25, 4.0);
  EXPECT_EQ(interpolate(a, b, 0.001, 0.0).q[0], a.q[0]);
  EXPECT_EQ(interpolate(a, b, 0.001, 0.001).q[0], b.q[0]);
  EXPECT_EQ(interpolate(a, b, 0.001, -1.0).dq[0], a.dq[0]);
  EXPECT_EQ(interpolate(a, b, 0.001, 1.0).ddq[0], b.ddq[0]);
  const JointSample rest = state(0.1234567890123, 0.0, 0.0);
  for (double t = 0.0; t < 0.008; t += 0.0001) EXPECT_EQ(interpolate(rest, rest, 0.008, t).q[0], rest.q[0]) << t;
}

TEST(Interpolate, IsThePolynomialThatBothStatesLieOn) {
  // q = 1 + 2t - 3t^2 + 4t^3 - 5t^4 + 6t^5
  const auto at = [](double t) {
    return state(1 + t * (2 + t * (-3 + t * (4 + t * (-5 + 6 * t)))), 2 + t * (-6 + t * (12 + t * (-20 + 30 * t))),
                 -6 + t * (24 + t * (-60 + 120 * t)));
  };
  for (double t = 0.0; t <= 0.5; t += 0.05) {
    const JointSample got = interpolate(at(0.0), at(0.5), 0.5, t), want = at(t);
    EXPECT_NEAR(got.q[0], want.q[0], 1e-14);
    EXPECT_NEAR(got.dq[0], want.dq[0], 1e-13);
    EXPECT_NEAR(got.ddq[0], want.ddq[0], 1e-12);
  }
}

/// Between set points 1 ms apart a motion of bounded jerk is met within J h^3 / 96: far below what any joint resolves.
TEST(SetPointSeries, T3_ResampledMotionIsTheIdealOne) {
  SetPointSeries series;
  fill(series, kMillisecond, 500 * kMillisecond);
  double worst_q = 0.0, worst_v = 0.0;
  for (Nanoseconds t = 0; t < 500 * kMillisecond; t += 37'123) {
    JointSample got = state(0, 0, 0);
    ASSERT_EQ(series.sample(t, got), SetPointSeries::Place::kInside);
    const JointSample want = ideal(to_seconds(t));
    worst_q = std::max(worst_q, std::abs(got.q[0] - want.q[0]));
    worst_v = std::max(worst_v, std::abs(got.dq[0] - want.dq[0]));
  }
  EXPECT_LE(worst_q, 100.0 * 1e-9 / 96) << "rad";
  EXPECT_LE(worst_v, 100.0 * 1e-6 / 16) << "rad/s";
}

/// What a device is told at its instants keeps the limits: differences over 8 ms are means of derivatives, and those of
/// the polynomial between two set points leave the limits only where the jerk switches, by half at most.
TEST(SetPointSeries, T3_ResampledMotionKeepsTheLimits) {
  SetPointSeries series;
  fill(series, kMillisecond, 500 * kMillisecond);
  constexpr Nanoseconds kDense = 10'000;
  double v = 0.0, a = 0.0, j = 0.0, before = 0.0;
  for (Nanoseconds t = 0; t < 500 * kMillisecond; t += kDense) {
    JointSample got = state(0, 0, 0);
    (void)series.sample(t, got);
    v = std::max(v, std::abs(got.dq[0]));
    a = std::max(a, std::abs(got.ddq[0]));
    if (t > 0) j = std::max(j, std::abs(got.ddq[0] - before) / to_seconds(kDense));
    before = got.ddq[0];
  }
  EXPECT_LE(v, 1.2 * 1.0001);
  EXPECT_LE(a, 4.0 * 1.001);
  EXPECT_LE(j, 100.0 * 1.6);
}

TEST(SetPointSeries, SaysWhereATimeLies) {
  SetPointSeries series;
  JointSample out = state(7, 0, 0);
  EXPECT_EQ(series.sample(0, out), SetPointSeries::Place::kEmpty);
  EXPECT_EQ(out.q[0], 7.0) << "untouched";
  fill(series, kMillisecond, 600 * kMillisecond);  // more than it holds
  EXPECT_EQ(series.sample(0, out), SetPointSeries::Place::kBefore) << "the oldest are gone";
  EXPECT_EQ(series.first().stamp, (601 - static_cast<Nanoseconds>(SetPointSeries::kCapacity)) * kMillisecond);
  EXPECT_EQ(series.sample(600 * kMillisecond, out), SetPointSeries::Place::kInside);
  EXPECT_EQ(series.sample(600 * kMillisecond + 1, out), SetPointSeries::Place::kBeyond);
  EXPECT_EQ(out.q[0], ideal(to_seconds(600 * kMillisecond)).q[0]) << "the newest";
  series.add({.cycle = 0, .stamp = 0, .q = state(9, 0, 0).q, .dq = state(0, 0, 0).q, .ddq = state(0, 0, 0).q});
  EXPECT_EQ(series.newest(), 600 * kMillisecond) << "an older one is ignored";
}

}  // namespace
}  // namespace takt::device
