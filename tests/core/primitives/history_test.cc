// History, sources, timers, counters and latches: what was, and when.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using net::Boolean;
using net::Integer;
using net::Real;

TEST(History, DelayGivesWhatWasNullsIncluded) {
  for (const int cycles : {0, 1, 3, 17}) {
    PrimitiveHarness delay("DelayReal", {{"cycles", cycles}});
    std::vector<std::optional<double>> all;
    Random random(1);
    for (int k = 0; k < 60; ++k) {
      all.push_back(random.unit() < 0.2 ? std::nullopt : std::optional(random.uniform(-1, 1)));
      if (all.back()) delay.set("input", *all.back());
      if (!all.back()) delay.set_null("input");
      const auto expected = k < cycles ? std::nullopt : all[static_cast<std::size_t>(k - cycles)];
      EXPECT_EQ(delay.step().get<Real>("value"), expected) << k;
    }
  }
}

TEST(History, ValueAgoIsLinearBetweenCycles) {
  PrimitiveHarness past("ValueAgo", {{"cycles", 50}});
  for (int k = 0; k <= 100; ++k) past.set("input", 2.0 * k).set("ago", 0.0).step();
  EXPECT_EQ(past.get<Real>("value"), 200.0);
  past.set("input", 202.0).set("ago", 0.0125).step();
  EXPECT_NEAR(*past.get<Real>("value"), 202.0 - 2.0 * 12.5, 1e-9);
  EXPECT_TRUE(past.set("ago", 0.0501).step().is_null("value"));
  EXPECT_TRUE(past.set("ago", -0.001).step().is_null("value"));
}

TEST(History, ExtremesSinceTheReset) {
  PrimitiveHarness extremes("Extremes");
  extremes.set("reset", false).step();
  EXPECT_TRUE(extremes.is_null("minimum"));
  for (const double x : {2.0, -1.0, 5.0}) extremes.set("input", x).step();
  EXPECT_EQ(extremes.get<Real>("minimum"), -1.0);
  EXPECT_EQ(extremes.get<Real>("maximum"), 5.0);
  EXPECT_EQ(extremes.set_null("input").step().get<Real>("maximum"), 5.0);
  extremes.set("reset", true).set("input", 1.0).step();
  EXPECT_EQ(extremes.get<Real>("minimum"), 1.0);
  EXPECT_EQ(extremes.get<Real>("maximum"), 1.0);
}

TEST(History, ATraceIsReadAtAnyTime) {
  PrimitiveHarness trace("Trace", {{"cycles", 10}});
  trace.set("record", true);
  for (int k = 0; k < 5; ++k) trace.set("input", 1.0 * k * k).step();
  trace.set("record", false).set("input", 99.0).set("time", 0.0025).step();
  EXPECT_NEAR(*trace.get<Real>("value"), 6.5, 1e-9);
  EXPECT_NEAR(*trace.get<Real>("length"), 0.004, 1e-15);
  EXPECT_TRUE(trace.set("time", 0.0041).step().is_null("value"));
  trace.set("record", true).set("input", 7.0).set("time", 0.0).step();  // a new recording
  EXPECT_EQ(trace.get<Real>("value"), 7.0);
  EXPECT_EQ(trace.step(20).get<Boolean>("full"), true);
  EXPECT_NEAR(*trace.get<Real>("length"), 0.009, 1e-15);
}

TEST(Source, SignalsAreTheirFormulas) {
  PrimitiveHarness ramp("Ramp", {{"from", 1.0}, {"to", 3.0}, {"duration", 0.1}}),
      jump("Step", {{"before", -1.0}, {"after", 2.0}, {"time", 0.05}});
  PrimitiveHarness sine("SineWave", {{"amplitude", 2.0}, {"mean", 1.0}, {"frequency", 7.0}, {"phase", 0.1}});
  PrimitiveHarness square("SquareWave", {{"amplitude", 2.0}, {"frequency", 10.0}, {"duty", 0.3}});
  PrimitiveHarness time("Time");
  for (int k = 0; k < 300; ++k) {
    const double t = k * 1e-3;
    EXPECT_NEAR(*ramp.step().get<Real>("value"), std::min(3.0, 1.0 + 20.0 * t), 1e-12);
    EXPECT_EQ(jump.step().get<Real>("value"), k < 50 ? -1.0 : 2.0);
    EXPECT_NEAR(*sine.step().get<Real>("value"), 1.0 + 2.0 * std::sin(2 * std::numbers::pi * (7.0 * t + 0.1)), 1e-9);
    if (k % 10 != 0) {  // not on an edge, where rounding decides
      EXPECT_EQ(square.step().get<Real>("value"), k % 100 < 30 ? 2.0 : -2.0) << k;
    } else {
      square.step();
    }
    EXPECT_NEAR(*time.step().get<Real>("elapsed"), t, 1e-12);
    EXPECT_EQ(time.get<Integer>("cycle"), k);
  }
}

TEST(Source, D5_NoiseRepeatsAndHasItsDistribution) {
  const auto draw = [](const char* type, const nlohmann::ordered_json& parameters) {
    PrimitiveHarness noise(type, parameters);
    std::vector<double> all;
    for (int k = 0; k < 20000; ++k) all.push_back(*noise.step().get<Real>("value"));
    return all;
  };
  const auto mean = [](const std::vector<double>& v) {
    double sum = 0.0;
    for (const double x : v) sum += x;
    return sum / static_cast<double>(v.size());
  };
  const auto uniform = draw("UniformNoise", {{"seed", 1}, {"low", 2.0}, {"high", 4.0}});
  EXPECT_EQ(uniform, draw("UniformNoise", {{"seed", 1}, {"low", 2.0}, {"high", 4.0}}));
  EXPECT_NE(uniform, draw("UniformNoise", {{"seed", 2}, {"low", 2.0}, {"high", 4.0}}));
  EXPECT_NE(uniform, draw("UniformNoise", {{"seed", 1}, {"stream", "b"}, {"low", 2.0}, {"high", 4.0}}));
  EXPECT_GE(*std::ranges::min_element(uniform), 2.0);
  EXPECT_LT(*std::ranges::max_element(uniform), 4.0);
  EXPECT_NEAR(mean(uniform), 3.0, 0.02);
  auto normal = draw("NormalNoise", {{"seed", 1}, {"mean", -1.0}, {"deviation", 0.5}});
  EXPECT_NEAR(mean(normal), -1.0, 0.02);
  for (double& x : normal) x = (x + 1.0) * (x + 1.0);
  EXPECT_NEAR(std::sqrt(mean(normal)), 0.5, 0.02);
}

TEST(Timer, OffDelayPulseAndDebounceCountWholeCycles) {
  const auto run = [](PrimitiveHarness& timer, const std::vector<int>& inputs) {
    std::vector<int> outputs;
    for (const int input : inputs) {
      if (input < 0) timer.set_null("input");
      if (input >= 0) timer.set("input", input > 0);
      const auto value = timer.step().get<Boolean>("value");
      outputs.push_back(value ? *value : -1);
    }
    return outputs;
  };
  using List = std::vector<int>;
  PrimitiveHarness off("OffDelay", {{"delay", 0.003}});
  EXPECT_EQ(run(off, {0, 1, 0, 0, 0, 0, 1, 0, -1, 0}), (List{0, 1, 1, 1, 0, 0, 1, 1, -1, 0}));
  PrimitiveHarness pulse("Pulse", {{"duration", 0.003}});
  EXPECT_EQ(run(pulse, {1, 0, 1, 0, 1, 1, 1, 1, 1, -1, 1}), (List{1, 1, 1, 0, 1, 1, 1, 0, 0, -1, 1}));
  PrimitiveHarness debounce("Debounce", {{"time", 0.002}});
  EXPECT_EQ(run(debounce, {1, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1}), (List{1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 1}));
}

TEST(Counter, CountsEdgesWithinBounds) {
  PrimitiveHarness counter("UpDownCounter", {{"initial", 1}, {"upper", 3}});
  counter.set("up", true).set("down", false).set("reset", false).step();
  EXPECT_EQ(counter.get<Integer>("count"), 2);  // true in the first cycle
  EXPECT_EQ(counter.step().get<Integer>("count"), 2);
  for (int i = 0; i < 5; ++i) counter.set("up", false).step().set("up", true).step();
  EXPECT_EQ(counter.get<Integer>("count"), 3);
  EXPECT_EQ(counter.get<Boolean>("at_upper"), true);
  for (int i = 0; i < 5; ++i) counter.set("down", true).step().set("down", false).step();
  EXPECT_EQ(counter.get<Integer>("count"), 0);
  EXPECT_EQ(counter.get<Boolean>("at_lower"), true);
  EXPECT_EQ(counter.set("reset", true).step().get<Integer>("count"), 1);
  EXPECT_FALSE(PrimitiveHarness("UpDownCounter", {{"initial", 5}, {"upper", 3}}).ready());
}

TEST(Latch, ResetMayWin) {
  PrimitiveHarness latch("ResetSetLatch");
  latch.set("set", true).set("reset", true).step();
  EXPECT_EQ(latch.get<Boolean>("value"), false);
  EXPECT_EQ(latch.set("reset", false).step().get<Boolean>("value"), true);
  EXPECT_EQ(latch.set("set", false).step().get<Boolean>("value"), true);
  EXPECT_EQ(latch.set("reset", true).step().get<Boolean>("value"), false);
  EXPECT_EQ(latch.set_null("set").set_null("reset").step().get<Boolean>("value"), true);
}

TEST(Latch, ToggleTurnsWithEachEdge) {
  PrimitiveHarness toggle("Toggle");
  toggle.set("reset", false).set("trigger", true);
  EXPECT_EQ(toggle.step().get<Boolean>("value"), true);
  EXPECT_EQ(toggle.step().get<Boolean>("value"), true);
  toggle.set("trigger", false).step().set("trigger", true);
  EXPECT_EQ(toggle.step().get<Boolean>("value"), false);
}

TEST(Edge, ChangesOfNumbersAndTexts) {
  PrimitiveHarness number("ChangedInteger"), text("ChangedString");
  EXPECT_EQ(number.set("input", 3).step().get<Boolean>("value"), false);
  EXPECT_EQ(number.step().get<Boolean>("value"), false);
  EXPECT_EQ(number.set("input", 4).step().get<Boolean>("value"), true);
  number.set_null("input").step();
  EXPECT_EQ(number.set("input", 9).step().get<Boolean>("value"), false);
  EXPECT_EQ(text.set("input", net::Text("a")).step().get<Boolean>("value"), false);
  EXPECT_EQ(text.set("input", net::Text("b")).step().get<Boolean>("value"), true);
  PrimitiveHarness any("AnyEdge");
  EXPECT_EQ(any.set("input", true).step().get<Boolean>("value"), true);
  EXPECT_EQ(any.set("input", false).step().get<Boolean>("value"), true);
  EXPECT_EQ(any.step().get<Boolean>("value"), false);
}

TEST(Selection, ByIndexIgnoresTheOthers) {
  PrimitiveHarness select("SelectByIndexReal");
  select.set("case_0", 10.0).set("case_7", 17.0).set("otherwise", -1.0);
  const std::pair<Integer, double> rows[] = {{0, 10.0}, {7, 17.0}, {8, -1.0}, {-1, -1.0}};
  for (const auto& [index, value] : rows)
    EXPECT_EQ(select.set<Integer>("index", index).step().get<Real>("value"), value);
  EXPECT_TRUE(select.set<Integer>("index", 3).step().is_null("value"));
  EXPECT_EQ(select.set_null("index").step().get<Real>("value"), -1.0);
}

TEST(Null, AGateIsShutByNull) {
  PrimitiveHarness gate("GateReal");
  gate.set("input", 2.0).set("open", true);
  EXPECT_EQ(gate.step().get<Real>("value"), 2.0);
  EXPECT_TRUE(gate.set("open", false).step().is_null("value"));
  EXPECT_TRUE(gate.set_null("open").step().is_null("value"));
}

}  // namespace
}  // namespace takt::test
