// Filters against what theory says of them: frequency response, steady state, sums written a second time.
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "tests/support/primitive_harness.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

using net::Boolean;
using net::Real;
using net::Wrench;
using Complex = std::complex<double>;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kFilterPeriod = 1e-3;

/// Size and phase with which a sine of `frequency` (whole cycles in 1 s) leaves the filter, once it has settled.
Complex response(PrimitiveHarness& filter, double frequency) {
  Complex sum = 0.0;
  for (int k = 0; k < 3000; ++k) {
    const double phase = kTurn * frequency * k * kFilterPeriod;
    filter.set("input", std::sin(phase)).step();
    if (k >= 2000) sum += *filter.get<Real>("value") * std::polar(1.0, -phase);
  }
  return sum * Complex(0.0, 2.0) / 1000.0;  // sin = (e^i - e^-i) / 2i
}

/// The analogue prototype at the frequency that the bilinear transform maps there.
Complex prototype(double frequency, double corner, double quality, double n2, double n1, double n0) {
  const Complex s(0.0, std::tan(kTurn / 2 * frequency * kFilterPeriod) / std::tan(kTurn / 2 * corner * kFilterPeriod));
  return (n2 * s * s + n1 * s / quality + n0) / (s * s + s / quality + 1.0);
}

TEST(Filter, DesignedOnesHaveTheResponseOfTheirPrototypes) {
  for (const double f : {2.0, 20.0, 50.0, 80.0, 200.0, 450.0}) {
    for (const double quality : {0.5, std::numbers::sqrt2 / 2, 3.0}) {
      SCOPED_TRACE(f);
      PrimitiveHarness low("SecondOrderLowPass", {{"cutoff", 50.0}, {"quality", quality}});
      PrimitiveHarness high("SecondOrderHighPass", {{"cutoff", 50.0}, {"quality", quality}});
      PrimitiveHarness notch("Notch", {{"frequency", 50.0}, {"quality", quality}});
      EXPECT_LT(std::abs(response(low, f) - prototype(f, 50, quality, 0, 0, 1)), 1e-9);
      EXPECT_LT(std::abs(response(high, f) - prototype(f, 50, quality, 1, 0, 0)), 1e-9);
      EXPECT_LT(std::abs(response(notch, f) - prototype(f, 50, quality, 1, 0, 1)), 1e-9);
    }
  }
}

TEST(Filter, DesignedOnesBeginSettled) {
  const auto constant = [](const char* type, const char* parameter) {
    PrimitiveHarness filter(type, {{parameter, 5.0}});
    return *filter.set("input", 3.0).step(50).get<Real>("value");
  };
  EXPECT_NEAR(constant("SecondOrderLowPass", "cutoff"), 3.0, 1e-9);
  EXPECT_NEAR(constant("SecondOrderHighPass", "cutoff"), 0.0, 1e-9);
  EXPECT_NEAR(constant("Notch", "frequency"), 3.0, 1e-9);
  // A frequency that a cycle of 1 ms cannot tell is no accident.
  EXPECT_FALSE(PrimitiveHarness("SecondOrderLowPass", {{"cutoff", 1e9}}).set("input", 3.0).step(50).is_null("value"));
}

TEST(Filter, BiquadIsItsDifferenceEquation) {
  const double b0 = 0.3, b1 = -0.2, b2 = 0.1, a1 = -0.9, a2 = 0.4;
  PrimitiveHarness filter("Biquad", {{"b0", b0}, {"b1", b1}, {"b2", b2}, {"a1", a1}, {"a2", a2}});
  Random random(1);
  const double steady = (b0 + b1 + b2) / (1 + a1 + a2);
  std::vector<double> x(2, 0.7), y(2, 0.7 * steady);
  filter.set("input", 0.7).step();
  EXPECT_NEAR(*filter.get<Real>("value"), 0.7 * steady, 1e-15);
  for (int k = 0; k < 200; ++k) {
    x.push_back(random.uniform(-1, 1));
    const std::size_t n = x.size() - 1;
    y.push_back(b0 * x[n] + b1 * x[n - 1] + b2 * x[n - 2] - a1 * y[n - 1] - a2 * y[n - 2]);
    EXPECT_NEAR(*filter.set("input", x[n]).step().get<Real>("value"), y[n], 1e-13);
  }
  for (const auto& [one, two] : {std::pair{0.0, 1.0}, {2.1, 1.0}, {-1.5, 0.4}}) {
    PrimitiveHarness bad("Biquad", {{"b0", 1.0}, {"b1", 0.0}, {"b2", 0.0}, {"a1", one}, {"a2", two}});
    EXPECT_THAT(bad.diagnostics(), Reports(Code::kOutOfRange, "/primitives/2/parameters/a1", {"a1"}))
        << one << " " << two;
  }
}

TEST(Filter, MovingAverageIsTheMeanOfItsWindow) {
  PrimitiveHarness average("MovingAverage", {{"cycles", 7}});
  Random random(2);
  std::vector<double> all;
  for (int k = 0; k < 100; ++k) {
    all.push_back(random.uniform(-1, 1));
    double sum = 0.0;
    const std::size_t count = std::min<std::size_t>(7, all.size());
    for (std::size_t i = all.size() - count; i < all.size(); ++i) sum += all[i];
    EXPECT_NEAR(*average.set("input", all.back()).step().get<Real>("value"), sum / static_cast<double>(count), 1e-14);
  }
  average.set_null("input").step();
  EXPECT_EQ(average.set("input", 5.0).step().get<Real>("value"), 5.0);
}

TEST(Filter, LowPassOfAWrenchIsThatOfItsNumbers) {
  PrimitiveHarness all("LowPassWrench", {{"cutoff", 20.0}}), one("LowPass", {{"cutoff", 20.0}});
  Random random(3);
  for (int k = 0; k < 50; ++k) {
    const Wrench w = harness::random_value<Wrench>(random, harness::Numbers::kModerate);
    all.set("input", w).step();
    one.set("input", w.torque.y()).step();
    EXPECT_EQ(all.get<Wrench>("value")->torque.y(), *one.get<Real>("value"));
  }
}

TEST(Filter, FilteredDifferentiatorFindsASlope) {
  PrimitiveHarness slope("FilteredDifferentiator", {{"cutoff", 50.0}});
  for (int k = 0; k < 200; ++k) slope.set("input", 3.0 * k * kFilterPeriod).step();
  EXPECT_NEAR(*slope.get<Real>("value"), 3.0, 1e-9);
  EXPECT_EQ(PrimitiveHarness("FilteredDifferentiator", {{"cutoff", 50.0}}).set("input", 3.0).step().get<Real>("value"),
            0.0);
}

TEST(Filter, IntegratorSumsAndDoesNotWindUp) {
  PrimitiveHarness sum("Integrator", {{"initial", 1.0}, {"upper", 1.5}, {"lower", -1.0}});
  sum.set("reset", false).set("input", 2.0).step();
  EXPECT_EQ(sum.get<Real>("value"), 1.0);
  EXPECT_NEAR(*sum.step(100).get<Real>("value"), 1.2, 1e-12);
  EXPECT_EQ(sum.step(1000).get<Real>("value"), 1.5);
  EXPECT_EQ(sum.get<Boolean>("limited"), true);
  sum.set("input", -2.0).step();
  EXPECT_NEAR(*sum.step().get<Real>("value"), 1.498, 1e-12);  // at once off the bound
  EXPECT_TRUE(sum.set_null("input").step(5).is_null("value"));
  EXPECT_NEAR(*sum.set("input", 0.0).step().get<Real>("value"), 1.496, 1e-12);
  EXPECT_EQ(sum.set("reset", true).step().get<Real>("value"), 1.0);
  EXPECT_FALSE(PrimitiveHarness("Integrator", {{"initial", 1.0}, {"upper", 0.5}}).ready());
}

/// A first-order plant under PI control: the closed loop reaches the set point without a remaining error.
TEST(Control, PidDrivesAPlantToItsSetPoint) {
  PrimitiveHarness pid(
      "Pid", {{"gain", 4.0}, {"integral_time", 0.1}, {"derivative_time", 0.002}, {"lower", -10.0}, {"upper", 10.0}});
  pid.set("feed_forward", 0.0).set("reset", false).set_null("initial");
  double y = 0.0, largest = 0.0;
  for (int k = 0; k < 3000; ++k) {
    pid.set("set_point", 1.0).set("measured", y).step();
    y += kFilterPeriod / 0.2 * (*pid.get<Real>("value") - y - 0.5);  // with a load of 0.5
    largest = std::max(largest, y);
  }
  EXPECT_NEAR(y, 1.0, 1e-6);
  EXPECT_LT(largest, 1.3);
}

TEST(Control, PidPartsAreThoseOfTheFormula) {
  PrimitiveHarness pid("Pid", {{"gain", 2.0}, {"integral_time", 0.5}, {"derivative_time", 0.1}, {"filter", 10.0}});
  pid.set("feed_forward", 0.25).set("reset", false).set_null("initial");
  double integral = 0.0, derivative = 0.0, before = 0.0;
  Random random(4);
  for (int k = 0; k < 200; ++k) {
    const double r = random.uniform(-1, 1), y = random.uniform(-1, 1), h = kFilterPeriod;
    pid.set("set_point", r).set("measured", y).step();
    if (k > 0) derivative = (0.01 * derivative - 2.0 * 0.1 * (y - before)) / (0.01 + h);
    EXPECT_NEAR(*pid.get<Real>("value"), 2.0 * (r - y) + 0.25 + integral + derivative, 1e-12);
    integral += 2.0 * h / 0.5 * (r - y);
    before = y;
  }
}

TEST(Control, PidTakesOverWithoutAJumpAndDoesNotWindUp) {
  PrimitiveHarness pid("Pid", {{"gain", 2.0}, {"integral_time", 0.1}, {"lower", -1.0}, {"upper", 1.0}});
  pid.set("feed_forward", 0.0).set("reset", false).set("initial", 0.4).set("set_point", 0.3).set("measured", 0.0);
  EXPECT_NEAR(*pid.step().get<Real>("value"), 0.4, 1e-15);
  pid.set("set_point", 100.0).step(5000);  // far out of reach for a long time
  EXPECT_EQ(pid.get<Real>("value"), 1.0);
  EXPECT_EQ(pid.get<Boolean>("limited"), true);
  pid.set("set_point", 0.0).step(200);
  pid.set("measured", 0.5).step(200);
  EXPECT_LT(*pid.get<Real>("value"), 0.0);  // the past is forgotten within a few tracking times
  pid.set("reset", true).set("set_point", 1.0).set("measured", 1.0);
  EXPECT_NEAR(*pid.step().get<Real>("value"), 0.4, 1e-15);
  EXPECT_TRUE(pid.set_null("measured").step().is_null("value"));
}

}  // namespace
}  // namespace takt::test
