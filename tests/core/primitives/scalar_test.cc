// Scalar, logic and sequence primitives: the equation, null on each input (rows N1, N2), the first cycle, no
// allocation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using net::Boolean;
using net::Integer;
using net::Real;
using Json = nlohmann::ordered_json;

struct Case {
  const char* type;
  Json parameters;
};

class ScalarContract : public testing::TestWithParam<Case> {};

TEST_P(ScalarContract, NullFirstCycleAndAllocation) {
  check_primitive_contract(GetParam().type, GetParam().parameters);
}

INSTANTIATE_TEST_SUITE_P(All, ScalarContract,
                         testing::Values(Case{"Add", Json::object()}, Case{"Subtract", Json::object()},
                                         Case{"Multiply", Json::object()}, Case{"Divide", Json::object()},
                                         Case{"Gain", {{"gain", 2.0}}}, Case{"Negate", Json::object()},
                                         Case{"AbsoluteValue", Json::object()}, Case{"Minimum", Json::object()},
                                         Case{"Maximum", Json::object()}, Case{"Constant", {{"constant", 3.0}}},
                                         Case{"GreaterThan", Json::object()}, Case{"LessThan", Json::object()},
                                         Case{"Near", {{"tolerance", 0.1}}}, Case{"InRange", Json::object()},

                                         Case{"IsNull", Json::object()}, Case{"CountNullAsTrue", Json::object()},
                                         Case{"DefaultTo", Json::object()}, Case{"HoldLast", {{"cycles", 3}}},
                                         Case{"RisingEdge", Json::object()}, Case{"FallingEdge", Json::object()},
                                         Case{"SetResetLatch", Json::object()}, Case{"OnDelay", {{"cycles", 3}}},
                                         Case{"CycleCounter", Json::object()}, Case{"Stopwatch", Json::object()},
                                         Case{"ElapsedCycles", {{"cycles", 4}}}, Case{"SnapshotReal", Json::object()},
                                         Case{"SnapshotFrame", Json::object()}, Case{"SnapshotJoints", Json::object()},
                                         Case{"Saturation", Json::object()}, Case{"RateLimiter", {{"rate_max", 100.0}}},
                                         Case{"LowPass", {{"cutoff", 50.0}}}, Case{"Differentiator", Json::object()}),
                         [](const auto& one) { return one.param.type; });

Real binary(const char* type, const char* output, Real a, Real b) {
  PrimitiveHarness harness(type);
  return harness.set("a", a).set("b", b).step().get<Real>(output).value_or(NAN);
}

TEST(Arithmetic, Equations) {
  EXPECT_EQ(binary("Add", "sum", 2, 3), 5);
  EXPECT_EQ(binary("Subtract", "difference", 2, 3), -1);
  EXPECT_EQ(binary("Multiply", "product", 2, 3), 6);
  EXPECT_EQ(binary("Divide", "quotient", 3, 2), 1.5);
  EXPECT_EQ(binary("Minimum", "least", 3, 2), 2);
  EXPECT_EQ(binary("Maximum", "greatest", 3, 2), 3);
  EXPECT_TRUE(std::isnan(binary("Divide", "quotient", 3, 0))) << "division by zero is null";
  EXPECT_TRUE(std::isnan(binary("Multiply", "product", 1e300, 1e300))) << "overflow is null (row N5)";
}

TEST(Logic, NullCountsAsTrueWhereAStopDependsOnIt) {  // row N3
  PrimitiveHarness certain("CountNullAsTrue");
  EXPECT_EQ(certain.step().get<Boolean>("certain"), true);
  EXPECT_EQ(certain.set("value", false).step().get<Boolean>("certain"), false);
  PrimitiveHarness latch("SetResetLatch");
  EXPECT_EQ(latch.set("set", false).set("reset", false).step().get<Boolean>("value"), false);
  EXPECT_EQ(latch.set_null("set").step().get<Boolean>("value"), true);
  EXPECT_EQ(latch.set("set", false).step(5).get<Boolean>("value"), true);
  EXPECT_EQ(latch.set("reset", true).step().get<Boolean>("value"), false);
}

TEST(Edges, LastOneCycle) {
  PrimitiveHarness rising("RisingEdge");
  EXPECT_EQ(rising.set("value", true).step().get<Boolean>("edge"), true);
  EXPECT_EQ(rising.step().get<Boolean>("edge"), false);
  EXPECT_EQ(rising.set_null("value").step().set("value", true).step().get<Boolean>("edge"), true);
  PrimitiveHarness falling("FallingEdge");
  EXPECT_EQ(falling.set("value", false).step().get<Boolean>("edge"), false);
  EXPECT_EQ(falling.set("value", true).step().set("value", false).step().get<Boolean>("edge"), true);
}

TEST(Timers, CountCycles) {
  PrimitiveHarness delay("OnDelay", {{"cycles", 3}});
  EXPECT_EQ(delay.set("value", true).step(2).get<Boolean>("delayed"), false);
  EXPECT_EQ(delay.step().get<Boolean>("delayed"), true);
  EXPECT_EQ(delay.set("value", false).step().get<Boolean>("delayed"), false);
  PrimitiveHarness counter("CycleCounter");
  EXPECT_EQ(counter.step().get<Integer>("count"), 0);
  EXPECT_EQ(counter.step(4).get<Integer>("count"), 4);
  PrimitiveHarness elapsed("ElapsedCycles", {{"cycles", 2}});
  EXPECT_EQ(elapsed.step(2).get<Boolean>("elapsed"), false);
  EXPECT_EQ(elapsed.step().get<Boolean>("elapsed"), true);
  PrimitiveHarness stopwatch("Stopwatch");
  EXPECT_NEAR(*stopwatch.set("running", true).step(250).get<Real>("time"), 0.25, 1e-12);
  EXPECT_NEAR(*stopwatch.set("running", false).step(50).get<Real>("time"), 0.25, 1e-12);
}

TEST(Snapshots, KeepTheValueOfTheEdge) {
  PrimitiveHarness snapshot("SnapshotReal");
  EXPECT_TRUE(snapshot.set("value", 1.0).set("take", false).step().is_null("value"));
  EXPECT_EQ(snapshot.set("value", 2.0).set("take", true).step().get<Real>("value"), 2.0);
  EXPECT_EQ(snapshot.set("value", 3.0).step().get<Real>("value"), 2.0);
  EXPECT_EQ(snapshot.set("take", false).step().set("take", true).step().get<Real>("value"), 3.0);
}

TEST(Signals, LimitsAndFilters) {
  PrimitiveHarness saturation("Saturation", {{"low", -1.0}, {"high", 2.0}});
  EXPECT_EQ(saturation.set("value", 5.0).step().get<Real>("limited"), 2.0);
  EXPECT_EQ(saturation.get<Boolean>("limit_reached"), true);
  EXPECT_EQ(saturation.set("value", 0.5).step().get<Real>("limited"), 0.5);
  PrimitiveHarness rate("RateLimiter", {{"rate_max", 1000.0}});
  EXPECT_EQ(rate.set("value", 4.0).set("reset", false).step().get<Real>("limited"), 4.0);
  EXPECT_NEAR(*rate.set("value", 9.0).step(3).get<Real>("limited"), 7.0, 1e-12);
  EXPECT_EQ(rate.set("reset", true).step().get<Real>("limited"), 9.0);
  PrimitiveHarness low_pass("LowPass", {{"cutoff", 10.0}});
  EXPECT_EQ(low_pass.set("value", 0.0).step().get<Real>("filtered"), 0.0);
  // A step settles as 1 - exp(-2 pi f t).
  EXPECT_NEAR(*low_pass.set("value", 1.0).step(50).get<Real>("filtered"), 1.0 - std::exp(-M_PI), 1e-12);
  PrimitiveHarness derivative("Differentiator");
  EXPECT_TRUE(derivative.set("value", 1.0).step().is_null("derivative"));
  EXPECT_NEAR(*derivative.set("value", 1.5).step().get<Real>("derivative"), 500.0, 1e-9);
}

TEST(Parameters, WrongOnesAreFindingsWithPointerAndRange) {
  PrimitiveHarness rate("RateLimiter", {{"rate_max", -1.0}});
  ASSERT_FALSE(rate.ready());
  EXPECT_THAT(rate.findings().to_string(), testing::HasSubstr("rate_max"));
  PrimitiveHarness missing("Gain");
  EXPECT_FALSE(missing.ready());
}

}  // namespace
}  // namespace takt::test
