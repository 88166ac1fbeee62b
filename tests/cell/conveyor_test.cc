// A belt as a device of a cell: its signals, its frame, and a tool that follows what it carries.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"

namespace takt::cell::conveyor_test {
namespace {

using test::parsed;

/// A cube on a belt that goes along y, and an arm beside it; the program begins above the cube.
Description cell_with(const std::string& steps, const std::string& expectations = "") {
  return parsed(fmt::format(R"({{"time_limit_s": 30, "devices": {{
      "arm": {{"model": "lwr4plus", "at": {{"in": "pedestal", "position_m": [0, 0, 0.75]}}}},
      "belt": {{"model": "belt_1m", "at": {{"in": "world", "position_m": [0.55, -0.5, 0], "rpy_deg": [0, 0, 90]}}}}}},
    "objects": {{
      "pedestal": {{"model": "pedestal", "at": {{"in": "world"}}}},
      "cube": {{"shape": "box", "size_m": [0.04, 0.04, 0.04], "mass_kg": 0.5, "fixed": false,
                "at": {{"in": "belt/belt", "position_m": [0.2, 0, 0.02]}}}}}},
    "frames": {{"over": {{"in": "belt/belt", "position_m": [0.2, 0, 0.2], "rpy_deg": [0, 180, 0]}}}},
    "program": {{"do": "sequence", "steps": [
      {{"do": "ptp", "to": {{"in": "over", "position_m": [0, 0, 0], "rpy_deg": [0, 0, 0]}}, "speed": 0.5}}, {}]}},
    "expectations": [{}]}})",
                            steps, expectations));
}

/// How far the tool is beside the cube along the belt, in a window of the run: the largest, m.
double beside(Description description, double from_s, double to_s) {
  double worst = 0.0;
  std::optional<double> begun;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    const auto y = [&](const char* body) { return built.world->body_pose(built.world->body(body)).translation().y(); };
    const double now = to_seconds(built.world->time());
    if (!begun && built.cell.digital_inputs.at("belt/running")->sample().value) begun = now;
    if (begun && now > *begun + from_s && now < *begun + to_s)
      worst = std::max(worst, std::abs(y("arm/flange") - y("cube")));
    return true;
  };
  const RunReport report = test::run(std::move(description), options);
  test::expect_passed(report);
  EXPECT_TRUE(begun);
  return worst;
}

std::string follow_at(double speed, double seconds) {
  return fmt::format(R"({{"do": "set", "output": "belt/speed", "value": {}}},
      {{"do": "set", "output": "belt/run", "value": true}},
      {{"do": "follow", "in": "over", "linear_max_m_s": 0.5, "seconds": {}}})",
                     speed, seconds);
}

TEST(Conveyor, AToolFollowsWhatItCarries) {
  EXPECT_LT(beside(cell_with(follow_at(0.1, 3.0)), 1.5, 2.9), 5e-4);
  EXPECT_LT(beside(cell_with(follow_at(0.3, 1.8)), 1.5, 1.7), 1e-3);
}

TEST(Conveyor, IsStartedAndStopped) {
  const test::Ran ran =
      test::run_kept(cell_with(follow_at(0.1, 1.0) + R"(, {"do": "set", "output": "belt/run", "value": false},
        {"do": "wait", "until": {"input": "belt/running", "is": false}, "timeout_s": 1})",
                               R"json({"kind": "signal", "signal": "belt/running", "is": false, "rises": 1},
                   {"kind": "value", "value": "$input('belt/position')", "at_most": 0.2})json"));
  test::expect_passed(ran.report);
}

TEST(Conveyor, WhatIsWrongIsSaid) {
  const Diagnostics faster_than_it_goes =
      test::refusal(cell_with(R"({"do": "set", "output": "belt/speed", "value": 0.6})"));
  EXPECT_THAT(faster_than_it_goes, takt::test::Reports(Code::kOutOfRange, "/program/steps/1/value", {"0.5"}));
}

}  // namespace
}  // namespace takt::cell::conveyor_test
