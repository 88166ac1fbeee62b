#include "record/pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/random.h"

namespace takt::record {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double greatest = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    EXPECT_EQ(std::isnan(a[i]), std::isnan(b[i])) << i;
    if (!std::isnan(a[i])) greatest = std::max(greatest, std::abs(a[i] - b[i]));
  }
  return greatest;
}

/// As it comes back from its text.
PieceCurve read_again(const PieceCurve& curve, std::size_t samples) {
  PieceCurve again{.exponent = curve.exponent, .rate_exponent = curve.rate_exponent, .period = curve.period};
  EXPECT_TRUE(read_pieces(to_text(curve), samples, again));
  EXPECT_EQ(to_text(again), to_text(curve));
  return again;
}

/// Motions and rests, steps, noise and null, one after the other, as the seed has it.
std::vector<double> random_curve(Random& random) {
  std::vector<double> values;
  double at = random.uniform(-2.0, 2.0);
  while (values.size() < 3000) {
    const auto length = static_cast<std::size_t>(random.uniform(1.0, 600.0));
    const double kind = random.uniform(0.0, 5.0), to = random.uniform(-2.0, 2.0);
    for (std::size_t i = 0; i < length; ++i) {
      const double s = static_cast<double>(i) / static_cast<double>(length);
      double value = at;
      if (kind < 1.0) value = at + (to - at) * s * s * (3.0 - 2.0 * s);
      if (kind >= 1.0 && kind < 2.0) value = at + 0.3 * std::sin(40.0 * s);
      if (kind >= 2.0 && kind < 3.0) value = at + random.uniform(-0.01, 0.01);
      if (kind >= 4.0) value = std::numeric_limits<double>::quiet_NaN();
      values.push_back(value);
    }
    if (kind < 1.0) at = to;
    if (kind >= 3.0 && kind < 4.0) at = to;
  }
  return values;
}

/// The property that a golden relies on: whatever the curve, each sample is within the tolerance, and null stays null.
TEST(Pieces, EverySampleIsWithinTheTolerance) {
  Random random(39);
  for (int round = 0; round < 20; ++round) {
    const auto values = random_curve(random);
    for (const double tolerance : {1e-4, 5e-3, 0.2}) {
      const auto curve = fit_pieces(values, tolerance);
      ASSERT_TRUE(curve);
      EXPECT_LE(distance(values_of(read_again(*curve, values.size())), values), tolerance * (1.0 + 1e-9));
    }
  }
}

TEST(Pieces, ACurveAndItsRateAreWithinTheirTolerances) {
  Random random(40);
  for (int round = 0; round < 10; ++round) {
    std::vector<double> values, rates;
    double at = random.uniform(-2.0, 2.0);
    while (values.size() < 3000) {
      const auto length = static_cast<std::size_t>(random.uniform(200.0, 800.0));
      const double by = round % 2 == 0 ? random.uniform(-0.2, 0.2) : 0.0, span = 1e-3 * static_cast<double>(length);
      for (std::size_t i = 0; i < length; ++i) {
        const double s = static_cast<double>(i) / static_cast<double>(length);
        values.push_back(at + by * s * s * s * (10.0 + s * (-15.0 + 6.0 * s)));
        rates.push_back(30.0 * by * s * s * (1.0 - s) * (1.0 - s) / span);
      }
      at += by;
    }
    const auto curve = fit_rate_pieces(values, rates, kPeriod, 5e-4, 5e-3);
    ASSERT_TRUE(curve);
    const PieceCurve again = read_again(*curve, values.size());
    EXPECT_LE(distance(values_of(again), values), 5e-4 * (1.0 + 1e-9));
    EXPECT_LE(distance(rates_of(again), rates), 5e-3 * (1.0 + 1e-9));
    EXPECT_LT(to_text(*curve).size(), 60u * (round % 2 == 0 ? 10u : 1u)) << "smooth motions are short texts";
  }
}

TEST(Pieces, WhatCannotBeCountedInStepsIsNoCurve) {
  EXPECT_FALSE(fit_pieces(std::vector{0.0, std::numeric_limits<double>::infinity()}, 1e-3));
  EXPECT_FALSE(fit_pieces(std::vector{0.0, 1e30}, 1e-3));
  EXPECT_FALSE(fit_pieces(std::vector{0.0, 1.0}, 0.0));
  EXPECT_FALSE(fit_rate_pieces(std::vector{0.0}, std::vector{0.0, 1.0}, kPeriod, 1e-3, 1e-2));
}

TEST(Pieces, OtherTextsAreRefused) {
  PieceCurve curve;
  for (const char* text : {"0", "?", "~~~~~~~~", "zzzzzzzzzzzzzzzzzzzz", "E", "10", "é"})
    EXPECT_FALSE(read_pieces(text, 3, curve)) << text;
  EXPECT_TRUE(read_pieces("", 0, curve));
}

}  // namespace
}  // namespace takt::record
