// Figures of force control in the simulation, as bounds: a selection of what bench_force measures. True contact forces,
// three arms.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "core/base/diagnostics.h"
#include "tests/cell/described.h"

namespace takt::cell::force_figures_test {
namespace {

using testing::HasSubstr;

/// Of the probe on the block along the block's normal, N, from the first contact on; and how the run ended.
struct Trace {
  std::vector<double> force;
  RunReport report;

  [[nodiscard]] std::span<const double> end(std::size_t cycles) const {
    return std::span(force).last(std::min(cycles, force.size()));
  }
  [[nodiscard]] double mean(std::size_t cycles) const {
    const auto last = end(cycles);
    return std::accumulate(last.begin(), last.end(), 0.0) / static_cast<double>(last.size());
  }
  [[nodiscard]] double deviation(std::size_t cycles) const {
    const double middle = mean(cycles);
    double squares = 0.0;
    for (const double f : end(cycles)) squares += (f - middle) * (f - middle);
    return std::sqrt(squares / static_cast<double>(end(cycles).size()));
  }
  /// From 50 ms after the contact on: after the blow of the arm's mass.
  [[nodiscard]] double most() const { return std::ranges::max(std::span(force).subspan(50)); }
  /// It ended because of this parameter of the last step.
  [[nodiscard]] bool ended_by(std::string_view parameter) const {
    return std::ranges::any_of(report.diagnostics.list(), [&](const Diagnostic& d) {
      return d.code == Code::kConditionNotMet && d.pointer.ends_with(parameter);
    });
  }
};

struct Surface {
  double stiffness = 1e5;  ///< N/m
  double slope_deg = 0.0;
  std::string parts = R"({"shape": "box", "size_m": [0.1, 0.3, 0.05]})";
};

/// An arm with a probe whose ball is 5 mm above the block, 40 mm from its middle, tared; then the steps.
Trace run(const std::string& arm, const Surface& surface, const std::string& steps) {
  const std::string text = fmt::format(
      R"({{"time_limit_s": 30, "devices": {{
        "arm": {{"model": "{}", "at": {{"in": "world", "position_m": [0, 0, 0.75]}}}},
        "wrist": {{"model": "ft_gamma", "on": "arm"}}, "probe": {{"model": "probe_ball", "on": "wrist"}}}},
      "objects": {{"block": {{"parts": [{}], "stiffness_N_m": {}, "friction": 0.2,
        "at": {{"in": "world", "position_m": [0.56, 0, 0.8], "rpy_deg": [{}, 0, 0]}}}}}},
      "program": {{"do": "sequence", "steps": [
        {{"do": "ptp", "to": {{"in": "block", "position_m": [0, -0.04, 0.035], "rpy_deg": [{}, 0, 0]}}}},
        {{"do": "wait", "seconds": 0.3}}, {{"do": "tare"}}, {}]}},
      "expectations": [{{"kind": "limits"}}]}})",
      arm, surface.parts, surface.stiffness, surface.slope_deg, 180.0 - surface.slope_deg, steps);
  static const device::ModelLibrary models({"models"});
  auto session = Session::create(test::parsed(text), models);
  EXPECT_TRUE(session) << session.error().to_string();
  Trace trace;
  if (!session) return trace;
  const double tilt = surface.slope_deg * M_PI / 180.0;
  const Eigen::Vector3d into(0.0, std::sin(tilt), -std::cos(tilt));
  std::optional<std::size_t> watch;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    if (!watch) watch = built.world->watch_contact("probe", "block").value();
    const double force = into.dot(built.world->contact(*watch).force_W);
    if (force > 0.0 || !trace.force.empty()) trace.force.push_back(force);
    return true;
  };
  trace.report = (*session)->run(options);
  return trace;
}

std::string press(double force, const std::string& more) {
  return fmt::format(R"({{"do": "press", "direction": [0, 0, -1], "in": "block", "force_N": {}, "approach_m_s": 0.005,
      "travel_m": 0.05{}}})",
                     force, more);
}

struct Case {
  const char* arm;
  double stiffness, force;
  double over;    ///< share of the force
  double within;  ///< s
};

TEST(ForceFigures, APressReachesItsForceAndHoldsIt) {
  for (const Case& one : {Case{"lwr4plus", 1e5, 20.0, 1.1, 0.5},
                          {"lwr4plus", 1e6, 50.0, 1.1, 0.5},
                          {"lwr4plus", 1e4, 20.0, 1.1, 1.0},
                          {"ur5", 1e5, 20.0, 1.1, 0.5},
                          {"ur5", 1e6, 20.0, 1.1, 0.5},
                          {"tx90", 1e5, 20.0, 1.1, 0.5},
                          {"tx90", 1e4, 20.0, 1.1, 1.0}}) {
    SCOPED_TRACE(fmt::format("{} {} N/m {} N", one.arm, one.stiffness, one.force));
    const Trace trace = run(one.arm, {.stiffness = one.stiffness}, press(one.force, R"(, "seconds": 1.5)"));
    ASSERT_EQ(trace.report.verdict, Verdict::kPassed) << trace.report.diagnostics.to_string();
    EXPECT_LT(trace.most(), one.over * one.force);
    const std::size_t rest = trace.force.size() - static_cast<std::size_t>(1e3 * one.within);
    EXPECT_NEAR(trace.mean(rest), one.force, 0.05 * one.force);
    EXPECT_LT(trace.deviation(1000), std::max(0.02 * one.force, 0.3));
  }
}

TEST(ForceFigures, ALightForceOnSteelDoesNotSwing) {
  const Trace trace = run("ur5", {.stiffness = 1e6}, press(5.0, R"(, "seconds": 2)"));
  ASSERT_EQ(trace.report.verdict, Verdict::kPassed) << trace.report.diagnostics.to_string();
  EXPECT_NEAR(trace.mean(1000), 5.0, 0.25);
  EXPECT_LT(trace.deviation(1000), 0.3);
}

TEST(ForceFigures, ASlidingForceIsTheOneThatIsWanted) {
  const std::string slide = press(8.0, R"(, "seconds": 0.3)") +
                            R"(, {"do": "lin", "to": {"by_m": [0, 0.06, 0]}, "velocity_m_s": 0.02, "acceleration": 0.5,
      "force_offset": {"force_N": 8, "reach_m": 0.03}})";
  for (const char* arm : {"lwr4plus", "ur5", "tx90"}) {
    SCOPED_TRACE(arm);
    const Trace trace = run(arm, {}, slide);
    ASSERT_EQ(trace.report.verdict, Verdict::kPassed) << trace.report.diagnostics.to_string();
    EXPECT_NEAR(trace.mean(2800), 8.0, 0.03 * 8.0);
    EXPECT_LT(trace.deviation(2800), 0.05 * 8.0);
    EXPECT_GT(std::ranges::min(trace.end(2800)), 0.0) << "contact is never lost";
  }
}

struct Slide {
  const char* arm;
  double speed;  ///< m/s
};

/// A pipe of 150 mm radius, its crown where the top of the block is.
const Surface kPipe{.parts = R"({"shape": "cylinder", "radius_m": 0.15, "length_m": 0.3,
    "position_m": [0, 0, -0.125], "rpy_deg": [0, 90, 0]})"};

std::string slide_over_pipe(double speed, const std::string& more) {
  return press(10.0, R"(, "seconds": 0.3)") +
         fmt::format(R"(, {{"do": "lin", "to": {{"by_m": [0, 0.08, 0]}}, "velocity_m_s": {}, "acceleration": 0.3,
      "force_offset": {{"force_N": 10, "reach_m": 0.03, "velocity_max_m_s": 0.04{}}}}})",
                     speed, more);
}

TEST(ForceFigures, TheForceIsHeldOverTheCrownOfAPipe) {
  for (const double stiffness : {1e5, 6e5}) {
    for (const Slide& one : {Slide{"lwr4plus", 0.02}, {"lwr4plus", 0.05}, {"ur5", 0.05}, {"tx90", 0.02}}) {
      SCOPED_TRACE(fmt::format("{} {} m/s on {} N/m", one.arm, one.speed, stiffness));
      Surface pipe = kPipe;
      pipe.stiffness = stiffness;
      const Trace trace = run(one.arm, pipe, slide_over_pipe(one.speed, ""));
      ASSERT_EQ(trace.report.verdict, Verdict::kPassed) << trace.report.diagnostics.to_string();
      // All but the first 0.3 s, in which the slope of the pipe's side begins at once.
      const auto cycles = static_cast<std::size_t>(1e3 * 0.08 / one.speed);
      EXPECT_NEAR(trace.mean(cycles - 300), 10.0, 0.05 * 10.0) << "deviation " << trace.deviation(cycles - 300);
      EXPECT_GT(std::ranges::min(trace.end(cycles)), 0.0) << "contact is never lost";
    }
  }
}

/// A ball of 5 mm climbs it within 3 mm. What takes that for a slope rises on behind it.
TEST(ForceFigures, AnEdgeIsNoSlope) {
  const Surface edge{.parts = R"({"shape": "box", "size_m": [0.1, 0.3, 0.05]},
    {"shape": "box", "size_m": [0.1, 0.1, 0.05], "position_m": [0, 0.05, 0.001]})"};
  for (const char* arm : {"lwr4plus", "ur5"}) {
    for (const double speed : {0.02, 0.05}) {
      SCOPED_TRACE(fmt::format("{} {} m/s", arm, speed));
      const Trace trace =
          run(arm, edge,
              press(8.0, R"(, "seconds": 0.5)") + fmt::format(R"(, {{"do": "lin", "to": {{"by_m": [0, 0.08, 0]}},
        "velocity_m_s": {}, "acceleration": 0.5, "force_offset": {{"force_N": 8, "reach_m": 0.03}}}})",
                                                              speed));
      ASSERT_EQ(trace.report.verdict, Verdict::kPassed) << trace.report.diagnostics.to_string();
      const auto cycles = static_cast<std::size_t>(1e3 * 0.08 / speed);
      EXPECT_GT(std::ranges::min(trace.end(cycles)), 0.0) << "contact is never lost";
      EXPECT_GT(std::ranges::max(trace.end(cycles)), 1.3 * 8.0) << "the edge is there";
    }
  }
}

TEST(ForceFigures, AForceThatIsLeftForLongerThanDeclaredIsSaidSo) {
  // It begins 40 mm before the crown and ends 60 mm behind it, lower than it may go.
  const auto slide = [](const char* more) {
    return press(10.0, R"(, "seconds": 0.3)") +
           fmt::format(R"(, {{"do": "lin", "to": {{"by_m": [0, 0.1, 0]}}, "velocity_m_s": 0.02, "acceleration": 0.3,
      "force_offset": {{"force_N": 10, "reach_m": 0, "retreat_m": 0.03{}}}}})",
                       more);
  };
  const Trace lost = run("lwr4plus", kPipe, slide(R"(, "lost_max_s": 0.1)"));
  EXPECT_EQ(lost.report.verdict, Verdict::kError);
  EXPECT_TRUE(lost.ended_by("/force_offset/lost_max_s")) << lost.report.diagnostics.to_string();
  const Trace off = run("lwr4plus", kPipe, slide(R"(, "lost_max_s": 100, "off_force_max_s": 0.2)"));
  EXPECT_EQ(off.report.verdict, Verdict::kError);
  EXPECT_TRUE(off.ended_by("/force_offset/off_force_max_s")) << off.report.diagnostics.to_string();
  const Trace allowed = run("lwr4plus", kPipe, slide(R"(, "lost_max_s": 100)"));
  EXPECT_EQ(allowed.report.verdict, Verdict::kPassed) << allowed.report.diagnostics.to_string();
}

TEST(ForceFigures, AGentleLineIsPlannedByDefault) {
  const Trace trace = run("lwr4plus", kPipe,
                          press(10.0, R"(, "seconds": 0.3)") +
                              R"(, {"do": "lin", "to": {"by_m": [0, 0.08, 0]}, "velocity_m_s": 0.01,
      "force_offset": {"force_N": 10, "reach_m": 0.03}})");
  ASSERT_EQ(trace.report.verdict, Verdict::kPassed) << trace.report.diagnostics.to_string();
  EXPECT_NEAR(trace.mean(8000), 10.0, 0.5);
}

TEST(ForceFigures, DeeperThanExpectedIsSaidSo) {
  // 20 N sink 2 mm into a soft block.
  const Trace deep = run("lwr4plus", {.stiffness = 1e4}, press(20.0, R"(, "depth_max_m": 0.001)"));
  EXPECT_EQ(deep.report.verdict, Verdict::kError);
  EXPECT_TRUE(deep.ended_by("/depth_max_m")) << deep.report.diagnostics.to_string();
  const Trace shallow = run("lwr4plus", {.stiffness = 1e4}, press(20.0, R"(, "depth_max_m": 0.004)"));
  EXPECT_EQ(shallow.report.verdict, Verdict::kPassed) << shallow.report.diagnostics.to_string();
}

TEST(ForceFigures, AForceFromTheSideIsSaidSo) {
  // On a slope of 30 degrees without much friction the surface pushes to a side by half of the force.
  const Surface slope{.stiffness = 1e5, .slope_deg = 30.0};
  const auto straight_down = [](double lateral) {
    return fmt::format(R"({{"do": "press", "direction": [0, 0, -1], "in": "world", "force_N": 20, "approach_m_s": 0.005,
        "lateral_max_N": {}}})",
                       lateral);
  };
  const Trace pushed = run("lwr4plus", slope, straight_down(3.0));
  EXPECT_EQ(pushed.report.verdict, Verdict::kError);
  EXPECT_TRUE(pushed.ended_by("/lateral_max_N")) << pushed.report.diagnostics.to_string();
  const Trace held = run("lwr4plus", slope, straight_down(15.0));
  EXPECT_EQ(held.report.verdict, Verdict::kPassed) << held.report.diagnostics.to_string();
}

}  // namespace
}  // namespace takt::cell::force_figures_test
