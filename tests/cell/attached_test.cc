// What tools of an arm hold without fingers: parts that are attached and detached.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"

namespace takt::cell::screw_test {
namespace {

using takt::test::Reports;
using test::parsed;
using test::Ran;
using test::refusal;
using test::run_kept;

// -- Parts that are held without fingers ------------------------------------------------------------------------------

/// An arm with a screwdriver over a screw in a rack; `steps` with the bit in the socket, 3 N on it.
Description over_a_screw(const std::string& steps) {
  return parsed(R"({"devices": {
      "arm": {"model": "lwr4plus", "at": {"position_m": [0, 0, 0.75]}}, "wrist": {"model": "ft_gamma", "on": "arm"},
      "driver": {"model": "screwdriver", "on": "wrist", "settings": {"bit": "M6"}}},
    "objects": {
      "rack": {"shape": "box", "size_m": [0.1, 0.1, 0.04], "at": {"position_m": [0.55, 0, 0.77]},
               "bores": [{"position_m": [0, 0, 0.02], "clearance_for": "M6"}]},
      "screw": {"screw": {"thread": "M6", "length_m": 0.012}, "at": {"in": "rack", "position_m": [0, 0, 0.008]}}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": {"in": "screw/socket", "position_m": [0, 0, -0.04], "rpy_deg": [0, 0, 0]}, "speed": 0.5},
      {"do": "tare"},
      {"do": "lin", "name": "in", "to": {"in": "screw/socket", "position_m": [0, 0, 0.008]}, "velocity_m_s": 0.01,
       "until": {"sensor": "wrist", "above_N": 3}},
      )" + steps +
                "]}}");
}

/// The bit rests on the bottom of the socket, and the magnet holds the screw.
TEST(AttachedParts, GoWithTheToolInTheBeliefAndInTruth) {
  const Ran ran = run_kept(over_a_screw(R"({"do": "attach", "grasp": "socket"},
      {"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "speed": 0.5})"));
  ASSERT_NE(ran.session, nullptr);
  ASSERT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  const BuiltCell& built = ran.built();
  EXPECT_EQ(built.cell.held.at("driver").object, "screw");
  const auto believed = built.cell.frames.pose("screw");
  ASSERT_TRUE(believed) << believed.error().to_string();
  const Eigen::Isometry3d truth = built.world->body_pose(built.world->body("screw"));
  EXPECT_LT((believed->translation() - truth.translation()).norm(), 0.001);
  EXPECT_GT(truth.translation().z(), 0.85);
  // The controller and the sensor know what hangs there now.
  const expression::MountedArm& arm = built.cell.arms.at("arm");
  EXPECT_NEAR(arm.device->tool().payload.mass - arm.unloaded->mass, built.cell.objects.at("screw").mass.mass, 1e-9);
}

TEST(AttachedParts, StayWhereTheProgramSaysThatTheyAreLeft) {
  const Ran ran = run_kept(over_a_screw(R"({"do": "attach", "tool": "driver", "part": "screw"},
      {"do": "detach", "onto": "rack", "position_m": [0, 0, 0.008], "rpy_deg": [0, 0, 30]})"));
  ASSERT_NE(ran.session, nullptr);
  ASSERT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  const expression::Cell& cell = ran.built().cell;
  EXPECT_TRUE(cell.held.empty());
  EXPECT_EQ(cell.frames.relation("screw")->parent, "rack");
  const auto X = cell.frames.pose("screw", "rack");
  ASSERT_TRUE(X);
  EXPECT_LT((X->translation() - Eigen::Vector3d(0, 0, 0.008)).norm(), 1e-9);
  EXPECT_NEAR(X->linear()(1, 0), 0.5, 1e-9);
}

TEST(AttachedParts, WhatCannotBeHeldIsReported) {
  EXPECT_THAT(refusal(over_a_screw(R"({"do": "attach", "grasp": "sockt"})")),
              Reports(Code::kUnknownName, "/program/steps/3/grasp", {"sockt", "socket"}));
  EXPECT_THAT(refusal(over_a_screw(R"({"do": "attach", "tool": "drivr"})")),
              Reports(Code::kUnknownName, "/program/steps/3/tool", {"drivr", "driver"}));
  EXPECT_THAT(refusal(over_a_screw(R"({"do": "attach", "part": "rack"})")),
              Reports(Code::kConflict, "/program/steps/3/part", {"rack"}));
  EXPECT_THAT(refusal(over_a_screw(R"({"do": "attach"}, {"do": "attach"})")),
              Reports(Code::kConflict, "/program/steps/4/tool", {"driver", "screw"}));
  EXPECT_THAT(refusal(over_a_screw(R"({"do": "detach"})")),
              Reports(Code::kConditionNotMet, "/program/steps/3/tool", {"driver"}));
  EXPECT_THAT(refusal(over_a_screw(R"({"do": "lin", "to": {"by_m": [0, 0, 0.05]}}, {"do": "attach"})")),
              Reports(Code::kConditionNotMet, "/program/steps/4", {"driver"}));
  EXPECT_THAT(refusal(over_a_screw(R"({"do": "attach"}, {"do": "detach", "onto": "rakc"})")),
              Reports(Code::kUnknownName, "/program/steps/4/onto", {"rakc"}));
  EXPECT_THAT(refusal(over_a_screw(R"({"do": "attach"}, {"do": "detach", "position_m": [0, 0, 0]})")),
              Reports(Code::kMissing, "/program/steps/4"));
}

/// Screws that stand in a rack do not overlap with it, and a bit that comes down beside the socket is a collision.
TEST(AttachedParts, ABoreIsEmptyInTheBelief) {
  EXPECT_FALSE(refusal(over_a_screw(R"({"do": "attach"})")).has_errors());
  EXPECT_THAT(refusal(over_a_screw(R"({"do": "lin", "to": {"by_m": [0, 0, 0.05]}},
      {"do": "lin", "to": {"in": "rack", "position_m": [0.03, 0, 0.015]}})")),
              Reports(Code::kCollision, "/program/steps/4", {"rack"}));
}

}  // namespace
}  // namespace takt::cell::screw_test
