// A compliant arm presses in the simulation: the force comes, whatever the springs are like (docs/how-to/force.md).
#include <algorithm>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "tests/support/reports.h"

namespace takt::cell::press_springs_test {
namespace {

using takt::test::ReportsAnywhere;

/// What the probe did to the block, N, cycle for cycle, and how the run ended.
struct Pressed {
  std::vector<double> force;
  bool rests = false;  ///< in the end, and nothing holds it
  RunReport report;

  /// Of the last cycles in which it pressed.
  [[nodiscard]] double mean(std::size_t cycles) const {
    const std::span<const double> last = std::span(force).last(cycles);
    return std::accumulate(last.begin(), last.end(), 0.0) / static_cast<double>(cycles);
  }
  [[nodiscard]] double swing(std::size_t cycles) const {
    const std::span<const double> last = std::span(force).last(cycles);
    return std::ranges::max(last) - std::ranges::min(last);
  }
  [[nodiscard]] double most() const { return std::ranges::max(force); }
};

/// An LWR with a probe 5 mm above a block, tared, in a control mode; then the steps.
/// @param acts  of an operator
Pressed run(const std::string& mode, const std::string& steps, const std::string& acts = "") {
  const std::string change = mode == "position" ? "" : R"({"do": "control_mode", "mode": ")" + mode + R"("},)";
  const auto description = parse_description(
      R"({"devices": {"arm": {"model": "lwr4plus"}, "wrist": {"model": "ft_gamma", "on": "arm"},
      "probe": {"model": "probe_ball", "on": "wrist"}},
      "objects": {"block": {"shape": "box", "size_m": [0.16, 0.16, 0.1],
          "at": {"in": "world", "position_m": [0.56, 0, 0.05]}}}, "time_limit_s": 60, "operator": [)" +
      acts + R"(],
      "program": {"do": "sequence", "steps": [
          {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.06], "rpy_deg": [180, 0, 0]}}, )" +
      change + R"({"do": "wait", "seconds": 0.5}, {"do": "tare"}, )" + steps + R"(]},
      "expectations": [{"kind": "limits"}]})");
  EXPECT_TRUE(description) << description.error().to_string();
  static const device::ModelLibrary models({"models"});
  auto session = Session::create(*description, models);
  EXPECT_TRUE(session) << session.error().to_string();
  Pressed pressed;
  if (!session) return pressed;
  std::optional<std::size_t> watch;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    if (!watch) watch = built.world->watch_contact("probe", "block").value();
    pressed.force.push_back(built.world->contact(*watch).force);
    const device::Arm& arm = *built.core->find_arm("arm");
    pressed.rests = arm.at_rest() && !arm.held();
    return true;
  };
  pressed.report = (*session)->run(options);
  return pressed;
}

std::string press(const std::string& more) {
  return R"({"do": "press", "direction": [0, 0, -1], "in": "world", "force_N": 10, "travel_m": 0.2)" + more;
}
std::string springs_of_tool(double stiffness) {
  return R"(, "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": )" + std::to_string(stiffness) + "}}";
}
std::string springs_of_joints(double stiffness) {
  return R"(, "compliance": {"mode": "joint_impedance", "stiffness_Nm_rad": )" + std::to_string(stiffness) + "}}";
}

struct Springs {
  const char *name, *mode;
  std::string key;
  double most;  ///< N: the tip also rubs along the block where the springs give way to a side
};

/// The softest that are worth while, and the stiffest that the device has, hardly damped ones too.
std::vector<Springs> all_springs() {
  const std::string hardly_damped = R"(, "compliance": {"mode": "cartesian_impedance", "damping_ratio": 0.1,
      "stiffness_N_m": 500}})";
  return {{"stiff", "position", "}", 16.0},
          {"tool 5000 N/m", "cartesian_impedance", springs_of_tool(5000), 13.0},
          {"tool 500 N/m", "cartesian_impedance", springs_of_tool(500), 13.0},
          {"tool 100 N/m", "cartesian_impedance", springs_of_tool(100), 13.0},
          {"hardly damped", "cartesian_impedance", hardly_damped, 16.0},
          {"joints 2000 Nm/rad", "joint_impedance", springs_of_joints(2000), 15.0},
          {"joints 100 Nm/rad", "joint_impedance", springs_of_joints(100), 30.0}};
}

TEST(PressOnSprings, TheForceComesOnAnySprings) {
  for (const Springs& springs : all_springs()) {
    SCOPED_TRACE(springs.name);
    const Pressed pressed = run(springs.mode, press(R"(, "seconds": 3)" + springs.key));
    ASSERT_EQ(pressed.report.verdict, Verdict::kPassed) << pressed.report.diagnostics.to_string();
    // What it presses with, and with what it rubs along the block: within a share of each other.
    EXPECT_GT(pressed.mean(1000), 9.3);
    EXPECT_LT(pressed.mean(1000), 12.5);
    EXPECT_LT(pressed.swing(1000), 4.0) << "it has settled";
    EXPECT_LT(pressed.most(), springs.most);
    RecordProperty(springs.name, static_cast<int>(1e3 * pressed.mean(1000)));
  }
}

TEST(PressOnSprings, WhatASearchFindsIsADropOfTheToolAndNotABentSpring) {
  // 20 mm of way bend the springs, 3 mm are the drop.
  const std::string search = R"({"do": "search", "direction": [0, 0, -1], "in": "world", "force_N": 10,
      "travel_m": 0.2, "radius_m": 0.006, "pitch_m": 0.004, "velocity_m_s": 0.005, "drop_m": 0.003)";
  const std::string on_end = R"(, "on_end": "continue")";
  const Pressed nowhere = run("cartesian_impedance", search + springs_of_tool(500));
  EXPECT_THAT(nowhere.report.diagnostics, ReportsAnywhere(Code::kConditionNotMet, {"on_end"}));
  const Pressed goes_on = run("cartesian_impedance", search + on_end + springs_of_tool(500));
  EXPECT_EQ(goes_on.report.verdict, Verdict::kPassed) << goes_on.report.diagnostics.to_string();
  EXPECT_GT(goes_on.mean(500), 8.0);
}

TEST(PressOnSprings, ASearchOnSpringsFindsTheEdge) {
  // The block ends 80 mm from where it begins; bent by 5 mm, the springs push the tool down there at once.
  const Pressed found = run("cartesian_impedance", R"({"do": "lin", "to": {"by_m": [0.072, 0, 0]}}, {"do": "search",
      "direction": [0, 0, -1], "in": "world", "force_N": 10, "radius_m": 0.015, "pitch_m": 0.005, "velocity_m_s": 0.02,
      "drop_m": 0.003, "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": [4000, 4000, 2000]}})");
  EXPECT_EQ(found.report.verdict, Verdict::kPassed) << found.report.diagnostics.to_string();
  EXPECT_TRUE(found.rests);
  EXPECT_GT(found.most(), 8.0) << "it pressed before";
}

TEST(PressOnSprings, ASearchOnSoftSpringsFollowsItsPattern) {
  // The edge is 8 mm away, and 10 N of force with friction bend 1000 N/m by 6 mm.
  const Pressed found = run("cartesian_impedance", R"({"do": "lin", "to": {"by_m": [0.072, 0, 0]}}, {"do": "search",
      "direction": [0, 0, -1], "in": "world", "force_N": 10, "radius_m": 0.015, "pitch_m": 0.005, "velocity_m_s": 0.01,
      "drop_m": 0.003, "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": [1000, 1000, 2000]}})");
  EXPECT_EQ(found.report.verdict, Verdict::kPassed) << found.report.diagnostics.to_string();
  EXPECT_TRUE(found.rests);
}

TEST(PressOnSprings, InATransactionAndAfterACancelNothingIsLeftBehind) {
  const std::string press_once = press(springs_of_tool(500));
  const std::string inside = R"({"do": "transaction", "commands": {"p": )" +
                             press(R"(, "start": true, "on": [{"entered": {"action": "p", "is": "at_force",
                                 "held_for_s": 0.5}, "cancel": "p"}])" +
                                   springs_of_tool(500)) +
                             "}}";
  const std::string away = R"(, {"do": "lin", "to": {"by_m": [0, 0, 0.06]}, "velocity_m_s": 0.05},
      {"do": "control_mode", "mode": "position"}, {"do": "ptp", "to": "home"})";
  for (const std::string& steps : {press_once, inside}) {
    SCOPED_TRACE(steps);
    const Pressed pressed = run("cartesian_impedance", steps + away);
    EXPECT_EQ(pressed.report.verdict, Verdict::kPassed) << pressed.report.diagnostics.to_string();
    EXPECT_GT(pressed.most(), 9.0);
    EXPECT_EQ(pressed.force.back(), 0.0) << "lifted off, home";
  }
}

// In the approach, while the springs are bent, while it presses.
TEST(PressOnSprings, L6_P2_ItMayBeInterruptedAnywhere) {
  const std::string steps = press(R"(, "seconds": 2)" + springs_of_tool(500));
  const auto act = [](const char* what, double after) {
    return R"({"at_step": "press", "after_s": )" + std::to_string(after) + R"(, "do": ")" + what + R"("})";
  };
  for (const double after : {0.5, 1.5, 3.0, 4.0, 5.0}) {
    SCOPED_TRACE(after);
    const Pressed cancelled = run("cartesian_impedance", steps, act("cancel", after));
    EXPECT_EQ(cancelled.report.verdict, Verdict::kPassed) << cancelled.report.diagnostics.to_string();
    EXPECT_TRUE(cancelled.rests);
    const Pressed paused = run("cartesian_impedance", steps, act("pause", after) + ", " + act("resume", after + 1.0));
    EXPECT_EQ(paused.report.verdict, Verdict::kPassed) << paused.report.diagnostics.to_string();
    EXPECT_GT(paused.mean(500), 9.3);
    EXPECT_LT(paused.most(), 13.0);
    const Pressed aborted = run("cartesian_impedance", steps, act("abort", after));
    EXPECT_EQ(aborted.report.verdict, Verdict::kError);
    for (const ExpectationResult& one : aborted.report.expectations) EXPECT_FALSE(one.judged) << one.measured;
  }
}

}  // namespace
}  // namespace takt::cell::press_springs_test
