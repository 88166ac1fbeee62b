#include "record/curves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/random.h"

namespace takt::record {
namespace {

constexpr double kNull = std::numeric_limits<double>::quiet_NaN();

struct Curve {
  std::vector<Nanoseconds> time;
  std::vector<double> value;
  [[nodiscard]] CurveView view() const { return {time, value}; }
};

/// A random walk with jumps, level stretches and gaps of null, at uneven times.
Curve random_curve(Random& random, std::size_t count, double null_share) {
  Curve curve;
  Nanoseconds time = 0;
  double value = 0.0;
  bool null = false;
  for (std::size_t i = 0; i < count; ++i) {
    time += 1 + static_cast<Nanoseconds>(random.bits() % 3) * kMillisecond;
    if (random.unit() < 0.02) value += random.uniform(-5, 5);
    if (random.unit() < 0.7) value += random.uniform(-0.1, 0.1);
    if (random.unit() < null_share) null = !null;
    curve.time.push_back(time);
    curve.value.push_back(null ? kNull : value);
  }
  return curve;
}

/// The tube by definition: all samples of the reference in the window, and its lines at the window's ends.
double brute_deviation(const CurveView& b, Nanoseconds t, double v, Nanoseconds dt) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  bool null = false;
  const auto take = [&](double x) {
    if (std::isnan(x)) {
      null = true;
    } else {
      low = std::min(low, x);
      high = std::max(high, x);
    }
  };
  for (std::size_t i = 0; i < b.time.size(); ++i) {
    if (b.time[i] >= t - dt && b.time[i] <= t + dt) take(b.value[i]);
  }
  take(value_at(b, t - dt));
  take(value_at(b, t + dt));
  if (std::isnan(v)) return null ? 0.0 : std::numeric_limits<double>::infinity();
  if (low > high) return std::numeric_limits<double>::infinity();
  return std::max({0.0, v - high, low - v});
}

TEST(Curves, TheTubeIsWhatItsDefinitionSays) {
  Random random(1);
  for (int round = 0; round < 60; ++round) {
    const double nulls = round % 3 == 0 ? 0.05 : 0.0;
    const Curve a = random_curve(random, 150, nulls), b = random_curve(random, 120, nulls);
    const auto dt = static_cast<Nanoseconds>(random.bits() % 8) * kMillisecond;
    const double dv = random.uniform(0, 2);
    double worst = 0.0;
    std::size_t outside = 0;
    for (std::size_t i = 0; i < a.time.size(); ++i) {
      const double d = brute_deviation(b.view(), a.time[i], a.value[i], dt);
      worst = std::max(worst, d);
      outside += d > dv ? 1 : 0;
    }
    const TubeResult result = follow_tube(a.view(), b.view(), dt, dv);
    EXPECT_EQ(result.max_deviation, worst);
    EXPECT_EQ(result.outside, outside);
  }
}

TEST(Curves, AShiftInTimeIsForgivenUpToDtAndNotBeyond) {
  Curve a, b;
  for (int k = 0; k < 1000; ++k) {
    a.time.push_back(k * kMillisecond);
    b.time.push_back(k * kMillisecond);
    a.value.push_back(k < 500 ? 0.0 : 1.0);
    b.value.push_back(k < 505 ? 0.0 : 1.0);
  }
  EXPECT_EQ(follow_tube(a.view(), b.view(), 5 * kMillisecond, 0.01).outside, 0u);
  EXPECT_EQ(follow_tube(a.view(), b.view(), 4 * kMillisecond, 0.01).outside, 1u);
  EXPECT_EQ(follow_tube(b.view(), a.view(), 5 * kMillisecond, 0.01).outside, 0u);
}

TEST(Curves, ThinningKeepsItsBoundAtEverySampleLeftOut) {
  Random random(2);
  for (int round = 0; round < 60; ++round) {
    const Curve full = random_curve(random, 400, round % 2 == 0 ? 0.03 : 0.0);
    const double tolerance = random.uniform(0.01, 0.5);
    Curve thinned;
    for (const std::size_t i : thin(full.view(), tolerance)) {
      thinned.time.push_back(full.time[i]);
      thinned.value.push_back(full.value[i]);
    }
    for (std::size_t i = 0; i < full.time.size(); ++i) {
      const double v = value_at(thinned.view(), full.time[i]);
      ASSERT_EQ(std::isnan(v), std::isnan(full.value[i])) << i;
      if (!std::isnan(v)) {
        ASSERT_LE(std::abs(v - full.value[i]), tolerance * (1 + 1e-9)) << i;
      }
    }
  }
}

TEST(Curves, ThinningLeavesFewPointsOfASmoothCurve) {
  Curve sine;
  for (int k = 0; k < 10'000; ++k) {
    sine.time.push_back(k * kMillisecond);
    sine.value.push_back(std::sin(1e-3 * k));
  }
  EXPECT_LT(thin(sine.view(), 1e-3).size(), 120u);
  for (double& v : sine.value) v = 3.0;
  EXPECT_EQ(thin(sine.view(), 1e-3).size(), 2u);
  EXPECT_TRUE(thin({}, 1.0).empty());
}

TEST(Curves, APictureKeepsPeaksAndGaps) {
  Curve curve;
  for (int k = 0; k < 100'000; ++k) {
    curve.time.push_back(k * kMillisecond);
    curve.value.push_back(k == 54'321 ? 9.0 : k == 12'345 ? -9.0 : k == 70'000 ? kNull : 0.0);
  }
  const auto chosen = choose_for_plot(curve.view(), 1000);
  EXPECT_LE(chosen.size(), 1002u);
  EXPECT_TRUE(std::ranges::is_sorted(chosen));
  for (const std::size_t wanted : {54'321u, 12'345u, 70'000u}) {
    EXPECT_TRUE(std::ranges::binary_search(chosen, wanted)) << wanted;
  }
}

TEST(Curves, PatternsMatch) {
  EXPECT_TRUE(matches("*", ""));
  EXPECT_TRUE(matches("/left/*", "/left/joints"));
  EXPECT_TRUE(matches("*.position", "a1.position"));
  EXPECT_TRUE(matches("a*c*e", "abcbcde"));
  EXPECT_FALSE(matches("a*c*e", "abcbcd"));
  EXPECT_FALSE(matches("/left", "/left/joints"));
  EXPECT_FALSE(matches("", "x"));
}

}  // namespace
}  // namespace takt::record
