// The equations of arithmetic, comparison, logic, signal and null primitives.
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

#include "tests/support/primitive_harness.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

using net::Boolean;
using net::Integer;
using net::Real;
using MaybeBool = std::optional<bool>;
using MaybeReal = std::optional<double>;

TEST(Arithmetic, Equations) {
  struct Row {
    const char* type;
    double a, b;
    MaybeReal value;
  };
  constexpr double kMax = std::numeric_limits<double>::max();
  for (const Row& row : {Row{"Add", 2, 3, 5.0}, Row{"Subtract", 2, 3, -1.0}, Row{"Multiply", 2, 3, 6.0},
                         Row{"Divide", 3, 2, 1.5}, Row{"Divide", 3, 0, {}}, Row{"Divide", 0, 0, {}},
                         Row{"Add", kMax, kMax, {}}, Row{"Min", 2, 3, 2.0}, Row{"Max", 2, 3, 3.0}}) {
    PrimitiveHarness primitive(row.type);
    primitive.set("a", row.a).set("b", row.b).step();
    EXPECT_EQ(primitive.get<Real>("value"), row.value) << row.type << " " << row.a << " " << row.b;
  }
  EXPECT_EQ(PrimitiveHarness("Negate").set("input", 2.5).step().get<Real>("value"), -2.5);
  EXPECT_EQ(PrimitiveHarness("Abs").set("input", -2.5).step().get<Real>("value"), 2.5);
  EXPECT_EQ(PrimitiveHarness("Gain", {{"factor", -3.0}}).set("input", 2.0).step().get<Real>("value"), -6.0);
}

TEST(Comparison, Equations) {
  const auto ask = [](const char* type, double a, double b) {
    return PrimitiveHarness(type).set("a", a).set("b", b).step().get<Boolean>("value");
  };
  EXPECT_EQ(ask("GreaterThan", 2, 1), true);
  EXPECT_EQ(ask("GreaterThan", 1, 1), false);
  EXPECT_EQ(ask("LessThan", 1, 2), true);
  EXPECT_EQ(ask("LessThan", 1, 1), false);
  EXPECT_EQ(ask("Equal", 1, 1), true);
  EXPECT_EQ(ask("Equal", 1, std::nextafter(1.0, 2.0)), false);
  PrimitiveHarness near("Equal", {{"tolerance", 0.125}, {"a", 1.0}});
  EXPECT_EQ(near.set("b", 1.125).step().get<Boolean>("value"), true);
  EXPECT_EQ(near.set("b", 1.126).step().get<Boolean>("value"), false);
  PrimitiveHarness range("InRange", {{"lower", -1.0}, {"upper", 2.0}});
  for (const auto& [x, inside] : {std::pair{-1.0, true}, {2.0, true}, {2.1, false}, {-1.1, false}})
    EXPECT_EQ(range.set("input", x).step().get<Boolean>("value"), inside) << x;
}

/// Row N2: all nine pairs of Kleene's tables.
TEST(Logic, N2_ThreeValuedTables) {
  constexpr MaybeBool kNull, kTrue = true, kFalse = false;
  struct Row {
    MaybeBool a, b, conjunction, disjunction, exclusive;
  };
  for (const Row& row : {Row{kTrue, kTrue, kTrue, kTrue, kFalse}, Row{kTrue, kFalse, kFalse, kTrue, kTrue},
                         Row{kTrue, kNull, kNull, kTrue, kNull}, Row{kFalse, kTrue, kFalse, kTrue, kTrue},
                         Row{kFalse, kFalse, kFalse, kFalse, kFalse}, Row{kFalse, kNull, kFalse, kNull, kNull},
                         Row{kNull, kTrue, kNull, kTrue, kNull}, Row{kNull, kFalse, kFalse, kNull, kNull},
                         Row{kNull, kNull, kNull, kNull, kNull}}) {
    const auto ask = [&row](const char* type) {
      PrimitiveHarness primitive(type);
      if (row.a) primitive.set("a", *row.a);
      if (row.b) primitive.set("b", *row.b);
      return primitive.step().get<Boolean>("value");
    };
    EXPECT_EQ(ask("And"), row.conjunction);
    EXPECT_EQ(ask("Or"), row.disjunction);
    EXPECT_EQ(ask("Xor"), row.exclusive);
  }
  EXPECT_EQ(PrimitiveHarness("Not").set("input", true).step().get<Boolean>("value"), kFalse);
  EXPECT_EQ(PrimitiveHarness("Not").step().get<Boolean>("value"), kNull);
}

TEST(Selection, N2_IgnoresTheBranchNotTaken) {
  PrimitiveHarness select("SelectReal");
  select.set("condition", true).set("if_true", 1.0);
  EXPECT_EQ(select.step().get<Real>("value"), 1.0);  // if_false is null
  EXPECT_TRUE(select.set("condition", false).step().is_null("value"));
  EXPECT_EQ(select.set("if_false", 2.0).set_null("if_true").step().get<Real>("value"), 2.0);
  EXPECT_TRUE(select.set_null("condition").step().is_null("value"));
}

TEST(Signal, SaturationLimitsAndSaysSo) {
  PrimitiveHarness saturation("Saturation", {{"lower", -1.0}, {"upper", 2.0}});
  EXPECT_EQ(saturation.set("input", 5.0).step().get<Real>("value"), 2.0);
  EXPECT_EQ(saturation.get<Boolean>("limited"), true);
  EXPECT_EQ(saturation.set("input", 2.0).step().get<Real>("value"), 2.0);
  EXPECT_EQ(saturation.get<Boolean>("limited"), false);
  PrimitiveHarness crossed("Saturation", {{"lower", 1.0}, {"upper", -1.0}});
  EXPECT_FALSE(crossed.ready());
  EXPECT_THAT(crossed.diagnostics(), Reports(Code::kOutOfRange, "/primitives/2/parameters/lower"));
}

TEST(Signal, RateLimiterBoundsEachStep) {
  PrimitiveHarness limiter("RateLimiter", {{"rate_max", 10.0}});
  limiter.set("reset", false);
  EXPECT_EQ(limiter.set("input", 1.0).step().get<Real>("value"), 1.0);  // first cycle: the input
  EXPECT_DOUBLE_EQ(*limiter.set("input", 5.0).step().get<Real>("value"), 1.01);
  EXPECT_DOUBLE_EQ(*limiter.set("input", -5.0).step(2).get<Real>("value"), 0.99);
  EXPECT_EQ(limiter.set("reset", true).step().get<Real>("value"), -5.0);
  limiter.set("reset", false).set_null("input").step();
  EXPECT_EQ(limiter.set("input", 7.0).step().get<Real>("value"), 7.0);  // null dropped the history
}

TEST(Signal, LowPassFollowsTheExponential) {
  PrimitiveHarness filter("LowPass", {{"cutoff", 10.0}});
  filter.set("input", 0.0).step();
  filter.set("input", 1.0).step(50);
  EXPECT_NEAR(*filter.get<Real>("value"), 1.0 - std::exp(-2 * std::numbers::pi * 10.0 * 0.050), 1e-12);
}

TEST(Signal, DifferentiatorNeedsTwoValues) {
  PrimitiveHarness slope("Differentiator");
  EXPECT_TRUE(slope.set("input", 1.0).step().is_null("value"));
  EXPECT_NEAR(*slope.set("input", 1.5).step().get<Real>("value"), 500.0, 1e-9);
  slope.set_null("input").step();
  EXPECT_TRUE(slope.set("input", 2.0).step().is_null("value"));
}

TEST(Null, HoldLastBridgesExactlyItsCycles) {
  PrimitiveHarness hold("HoldLastReal", {{"cycles", 2}});
  EXPECT_TRUE(hold.step().is_null("value"));
  hold.set("input", 4.0).step().set_null("input");
  EXPECT_EQ(hold.step().get<Real>("value"), 4.0);
  EXPECT_EQ(hold.step().get<Real>("value"), 4.0);
  EXPECT_TRUE(hold.step().is_null("value"));
}

TEST(Null, DefaultToAndIsNull) {
  PrimitiveHarness fallback("DefaultToReal");
  fallback.set("fallback", 1.0);
  EXPECT_EQ(fallback.step().get<Real>("value"), 1.0);
  EXPECT_EQ(fallback.set("input", 2.0).step().get<Real>("value"), 2.0);
  EXPECT_EQ(fallback.set_null("fallback").step().get<Real>("value"), 2.0);
  EXPECT_EQ(PrimitiveHarness("IsNullFrame").step().get<Boolean>("value"), true);
}

TEST(Null, SnapshotTakesAtTheEdgeOnly) {
  PrimitiveHarness snapshot("SnapshotReal");
  snapshot.set("input", 1.0).set("trigger", false).step();
  EXPECT_TRUE(snapshot.is_null("value"));
  EXPECT_EQ(snapshot.get<Boolean>("taken"), false);
  EXPECT_EQ(snapshot.set("input", 2.0).set("trigger", true).step().get<Real>("value"), 2.0);
  EXPECT_EQ(snapshot.set("input", 3.0).step().get<Real>("value"), 2.0);
  snapshot.set("trigger", false).step();
  EXPECT_EQ(snapshot.set("trigger", true).step().get<Real>("value"), 3.0);
  PrimitiveHarness at_once("SnapshotReal");
  EXPECT_EQ(at_once.set("input", 5.0).set("trigger", true).step().get<Real>("value"), 5.0);
}

TEST(Event, EdgesAsInIec61131) {
  PrimitiveHarness rising("RisingEdge"), falling("FallingEdge");
  struct Row {
    MaybeBool input, rises, falls;
  };
  for (const Row& row :
       {Row{true, true, false}, Row{true, false, false}, Row{false, false, true}, Row{true, true, false},
        Row{{}, {}, {}}, Row{true, false, false}, Row{{}, {}, {}}, Row{false, false, false}, Row{true, true, false}}) {
    for (PrimitiveHarness* edge : {&rising, &falling}) {
      if (row.input) edge->set("input", *row.input);
      if (!row.input) edge->set_null("input");
      edge->step();
    }
    EXPECT_EQ(rising.get<Boolean>("value"), row.rises);
    EXPECT_EQ(falling.get<Boolean>("value"), row.falls);
  }
}

TEST(Event, N3_LatchCountsADeadSensorAsSet) {
  PrimitiveHarness latch("SetResetLatch");
  latch.set("set", false).set("reset", false).step();
  EXPECT_EQ(latch.get<Boolean>("value"), false);
  latch.set_null("set").step();
  EXPECT_EQ(latch.get<Boolean>("value"), true);
  latch.set("set", false).step();
  EXPECT_EQ(latch.get<Boolean>("value"), true);
  latch.set("set", true).set("reset", true).step();
  EXPECT_EQ(latch.get<Boolean>("value"), true);  // set wins
  latch.set("set", false).step();
  EXPECT_EQ(latch.get<Boolean>("value"), false);
}

TEST(Event, TimersCountWholeCycles) {
  PrimitiveHarness delay("OnDelay", {{"delay", 0.1}});
  delay.set("input", true).step(100);
  EXPECT_EQ(delay.get<Boolean>("value"), false);
  EXPECT_EQ(delay.step().get<Boolean>("value"), true);  // true for 0.1 s since its first cycle
  delay.set("input", false).step();
  EXPECT_EQ(delay.set("input", true).step().get<Boolean>("value"), false);

  PrimitiveHarness watch("Stopwatch");
  watch.set("running", true).set("reset", false).step(11);
  EXPECT_NEAR(*watch.get<Real>("elapsed"), 0.010, 1e-15);
  EXPECT_EQ(watch.set("reset", true).step().get<Real>("elapsed"), 0.0);

  PrimitiveHarness counter("CycleCounter");
  counter.set("counted", true).set("reset", false).step(3);
  EXPECT_EQ(counter.get<Integer>("count"), 3);
  EXPECT_EQ(counter.set("counted", false).step().get<Integer>("count"), 3);
  EXPECT_EQ(counter.set("reset", true).step().get<Integer>("count"), 0);
}

}  // namespace
}  // namespace takt::test
