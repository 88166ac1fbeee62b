// Tool changes in whole runs: what the program believes, what the controller is told, and what goes wrong.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/device/arm.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"

namespace takt::cell::tool_changer_test {
namespace {

using takt::test::Reports;
using takt::test::ReportsAnywhere;
using test::parsed;
using test::Ran;
using test::refusal;
using test::run_kept;
using testing::AllOf;

/// Where a tool side truly is, m.
Eigen::Vector3d truth(const Ran& ran, const std::string& side) {
  return ran.built().world->body_pose(ran.built().world->body(side + "/plate")).translation();
}

/// What the controller is told beyond what is fixed to the arm, kg.
double load(const Ran& ran) {
  const expression::MountedArm& arm = ran.cell().arms.at("arm");
  return arm.device->tool().payload.mass - arm.unloaded->mass;
}

/// An arm with a changer over two stands with a hole: a probe lies in the left one, a gripper in the right one.
/// @param probe  where and on what the probe's side is
Description two_tools(const std::string& steps, const std::string& more = "", const std::string& arm = "",
                      const std::string& probe = R"("at": {"in": "left"})", const std::string& number = "2") {
  const std::string walls = R"("parts": [
      {"shape": "box", "size_m": [0.16, 0.023, 0.2], "position_m": [0, 0.0435, 0]},
      {"shape": "box", "size_m": [0.16, 0.023, 0.2], "position_m": [0, -0.0435, 0]}])";
  return parsed(R"({"devices": {
      "arm": {"model": "lwr4plus", "at": {"position_m": [0, 0, 0.2]})" +
                arm + R"(},
      "changer": {"model": "tool_changer", "on": "arm"},
      "probe side": {"model": "tool_side", )" +
                probe + R"(, "settings": {"number": 1}},
      "probe": {"model": "probe_ball", "on": "probe side"},
      "gripper side": {"model": "tool_side", "at": {"in": "right"}, "settings": {"number": )" +
                number + R"(}},
      "gripper": {"model": "wsg50", "on": "gripper side"}},
    "frames": {"left": {"in": "left dock", "position_m": [0, 0, 0.108], "rpy_deg": [0, 180, 0]},
               "right": {"in": "right dock", "position_m": [0, 0, 0.108], "rpy_deg": [0, 180, 0]}},
    "objects": {"left dock": {)" +
                walls + R"(, "at": {"position_m": [0.5, 0.15, 0.3]}},
                "right dock": {)" +
                walls + R"(, "at": {"position_m": [0.5, -0.15, 0.3]}}},
    "program": {"do": "sequence", "steps": [)" +
                steps + "]}" + more + "}");
}

constexpr const char* kToProbe =
    R"({"do": "ptp", "to": {"in": "left", "position_m": [0, 0, -0.06], "rpy_deg": [0, 0, 0]}, "tool": "changer",
        "speed": 0.6},
       {"do": "lin", "to": {"in": "left", "position_m": [0, 0, 0]}, "tool": "changer", "velocity_m_s": 0.1},)";
constexpr const char* kUp = R"({"do": "lin", "to": {"by_m": [0, 0, 0.2]}, "tool": "changer", "speed": 0.3})";
const std::string kTakeProbe = std::string(kToProbe) + R"({"do": "couple", "tool": "probe"},)" + kUp;

TEST(ToolChanges, WhatIsCoupledIsAToolOfTheArm) {
  const Ran ran = run_kept(two_tools(
      kTakeProbe +
          R"(, {"do": "lin", "name": "with the probe", "to": {"by_m": [0.05, 0, 0]}, "tool": "probe", "speed": 0.3})",
      R"(, "expectations": [
        {"kind": "belief", "frame": "probe side", "position_within_m": 0.001, "angle_within_deg": 0.2},
        {"kind": "belief", "frame": "probe/tcp", "position_within_m": 0.001, "angle_within_deg": 0.2},
        {"kind": "event", "source": "changer", "event": "coupled", "times": 1}])"));
  ASSERT_NE(ran.session, nullptr);
  ASSERT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  const expression::Cell& cell = ran.cell();
  EXPECT_EQ(cell.held.at("changer").object, "probe side");
  EXPECT_EQ(cell.tools.at("probe").arm, "arm");
  EXPECT_EQ(cell.tools.at("gripper").arm, "");
  // Through changer, tool side and probe: 36 mm, 22 mm and 110 mm.
  EXPECT_NEAR(cell.tools.at("probe").X_FT.at("tcp").translation().z(), 0.168, 1e-9);
  EXPECT_NEAR(cell.arms.at("arm").X_FT.translation().z(), 0.168, 1e-9) << "the last step named it";
  EXPECT_NEAR(load(ran), 0.285 + 0.099, 0.002) << "tool side and probe, for the controller";
  EXPECT_NEAR((truth(ran, "probe side") - cell.frames.pose("probe side")->translation()).norm(), 0.0, 0.001);
}

TEST(ToolChanges, WhatIsUncoupledStaysWhereItIs) {
  const Ran ran = run_kept(two_tools(kTakeProbe + R"(,
      {"do": "lin", "to": {"in": "left", "position_m": [0, 0, 0]}, "tool": "changer", "velocity_m_s": 0.1},
      {"do": "uncouple", "onto": "left dock"},)" +
                                         kUp,
                                     R"(, "expectations": [
        {"kind": "object_pose", "object": "probe side", "in": "left", "position_m": [0, 0, 0],
         "position_within_m": 0.0005, "angle_within_deg": 0.2},
        {"kind": "belief", "frame": "probe side", "position_within_m": 0.001, "angle_within_deg": 0.2}])"));
  ASSERT_NE(ran.session, nullptr);
  ASSERT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  EXPECT_TRUE(ran.cell().held.empty());
  EXPECT_EQ(ran.cell().tools.at("probe").arm, "");
  EXPECT_EQ(ran.cell().standing_on("probe side"), "left dock");
  EXPECT_NEAR(load(ran), 0.0, 1e-9);
}

TEST(ToolChanges, AToolMayHangOnTheChangerAtTheStart) {
  const Ran ran = run_kept(two_tools(R"({"do": "lin", "to": {"by_m": [0, 0, 0.05]}, "speed": 0.3})", "",
                                     R"(, "tool": "probe")", R"("on": "changer")"));
  ASSERT_NE(ran.session, nullptr);
  ASSERT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  EXPECT_EQ(ran.cell().tools.at("probe").arm, "arm");
  EXPECT_NEAR(load(ran), 0.285 + 0.099, 0.002);
  EXPECT_LT((truth(ran, "probe side") - ran.cell().frames.pose("probe side")->translation()).norm(), 0.001);
}

// -- Found before the run ---------------------------------------------------------------------------------------------

TEST(ToolChanges, AToolThatIsNotCoupledIsFoundBeforeTheRun) {
  EXPECT_THAT(refusal(two_tools(R"({"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "tool": "probe"})")),
              Reports(Code::kNotPossibleNow, "/program/steps/0/tool", {"probe", "arm"}));
  EXPECT_THAT(refusal(two_tools(R"({"do": "lin", "to": {"by_m": [0, 0, 0.1]}})", "", R"(, "tool": "gripper")")),
              Reports(Code::kNotPossibleNow, "/program/steps/0/tool", {"gripper"}))
      << "the default that the file declares";
  EXPECT_THAT(refusal(two_tools(R"({"do": "grip"})")), Reports(Code::kNotPossibleNow, "/program/steps/0/gripper"));
  EXPECT_THAT(refusal(two_tools(R"({"do": "attach", "tool": "probe", "part": "probe side"})")),
              Reports(Code::kNotPossibleNow, "/program/steps/0/tool", {"probe"}));
}

TEST(ToolChanges, AMissedDockIsFoundBeforeTheRun) {
  EXPECT_THAT(refusal(two_tools(R"({"do": "couple"})")), Reports(Code::kConditionNotMet, "/program/steps/0"));
  const std::string aside =
      R"({"do": "ptp", "to": {"in": "left", "position_m": [0.002, 0, -0.0005], "rpy_deg": [0, 0, 0]},
          "tool": "changer"},
         {"do": "couple", "tool": "probe side"})";
  EXPECT_THAT(refusal(two_tools(aside)), Reports(Code::kConditionNotMet, "/program/steps/1/tool", {"probe side"}));
  EXPECT_THAT(refusal(two_tools(std::string(kToProbe) + R"({"do": "couple", "tool": "gripper"})")),
              Reports(Code::kConditionNotMet, "/program/steps/2/tool", {"gripper side"}));
}

TEST(ToolChanges, WrongUseIsFoundBeforeTheRun) {
  EXPECT_THAT(refusal(two_tools(kTakeProbe + R"(, {"do": "couple"})")), Reports(Code::kConflict, "/program/steps/4"));
  EXPECT_THAT(refusal(two_tools(R"({"do": "couple", "tool": "prob", "changer": "changr", "timeout_s": 0})")),
              AllOf(Reports(Code::kUnknownName, "/program/steps/0/tool", {"prob", "probe"}),
                    Reports(Code::kUnknownName, "/program/steps/0/changer", {"changer"}),
                    Reports(Code::kOutOfRange, "/program/steps/0/timeout_s")));
  EXPECT_THAT(
      refusal(two_tools(kTakeProbe +
                        R"(, {"do": "lin", "to": {"in": "right", "position_m": [0, 0, 0]}, "tool": "changer"})")),
      ReportsAnywhere(Code::kCollision))
      << "the coupled probe is part of the arm";
}

/// A weight is screwed to the probe's tool side.
TEST(ToolChanges, AToolThatIsTooHeavyForTheArmIsFoundBeforeTheRun) {
  Description description = two_tools(kTakeProbe);
  ObjectEntry weight;
  weight.name = "weight";
  weight.at.in = "probe side";
  weight.at.X.translation() = Eigen::Vector3d(0.0, 0.0, 0.05);
  weight.parts.push_back({world::Box{{0.02, 0.02, 0.02}}, Eigen::Isometry3d::Identity()});
  weight.part_pointers.emplace_back("/objects/weight");
  weight.mass_kg = 6.8;
  description.objects.push_back(weight);
  EXPECT_THAT(refusal(std::move(description)), Reports(Code::kLimitExceeded, "/program/steps/2", {"arm", "lwr4plus"}));
}

TEST(ToolChanges, WrongCellsAreReported) {
  EXPECT_THAT(refusal(two_tools("", "", "", R"("at": {"in": "left"})", "1")),
              Reports(Code::kDuplicate, "/devices/gripper side/settings/number"));
  EXPECT_THAT(refusal(two_tools("", "", "", R"("at": {"in": "left"})", "0")),
              Reports(Code::kOutOfRange, "/devices/gripper side/settings/number"));
  EXPECT_THAT(refusal(two_tools("", "", "", R"("on": "arm")")),
              Reports(Code::kInvalidValue, "/devices/probe side/on", {"arm"}));
  EXPECT_THAT(refusal(two_tools("", "", "", R"("on": "changer")")), Reports(Code::kMissing, "/devices/arm/tool"))
      << "the changer and the probe: a default is never guessed";
}

TEST(ToolChanges, WhatCannotHangThereIsReported) {
  const auto devices = [](const std::string& more) {
    return parsed(R"({"devices": {"arm": {"model": "lwr4plus"}, "changer": {"model": "tool_changer", "on": "arm"},
        "side": {"model": "tool_side", "settings": {"number": 1}}, )" +
                  more + R"(}, "program": {"do": "sequence", "steps": []}})");
  };
  EXPECT_THAT(refusal(devices(R"("wrist": {"model": "ft_gamma", "on": "side"})")),
              Reports(Code::kUnsupported, "/devices/wrist/on", {"side"}));
  EXPECT_THAT(refusal(devices(R"("second": {"model": "ur5", "on": "side"})")),
              Reports(Code::kUnsupported, "/devices/second/on", {"side"}));
  EXPECT_THAT(refusal(devices(R"("loose": {"model": "tool_changer"})")),
              Reports(Code::kInvalidValue, "/devices/loose"));
  EXPECT_THAT(refusal(devices(R"("other": {"model": "tool_side", "on": "side", "settings": {"number": 2}})")),
              Reports(Code::kInvalidValue, "/devices/other/on", {"side"}));
  EXPECT_THAT(refusal(devices(R"("other": {"model": "tool_side", "on": "changer", "settings": {"number": 2}},
                                 "third": {"model": "tool_side", "on": "changer", "settings": {"number": 3}})")),
              Reports(Code::kConflict, "/devices/third/on", {"other"}));
}

// -- In the run -------------------------------------------------------------------------------------------------------

TEST(ToolChanges, WithoutAirTheStepFails) {
  const Ran ran = run_kept(two_tools(
      kTakeProbe, R"(, "faults": [{"at_s": 0, "do": "tool_changer", "changer": "changer", "fault": "no_air"}])"));
  ASSERT_NE(ran.session, nullptr);
  EXPECT_EQ(ran.report.verdict, Verdict::kError);
  EXPECT_THAT(ran.report.diagnostics, Reports(Code::kTimeout, "/program/steps/2", {"changer"}));
  EXPECT_TRUE(ran.cell().held.empty());
}

/// The believed place is right, the tool side lies 3 mm aside: somebody pushed it.
TEST(ToolChanges, AToolSideThatIsNotThereIsNotCoupled) {
  const std::string push =
      R"(, "faults": [{"at_s": 0.05, "do": "push", "body": "probe side/plate", "force_N": [9, 0, 0],
                       "seconds": 0.012}])";
  const Ran ran = run_kept(two_tools(kTakeProbe, push));
  ASSERT_NE(ran.session, nullptr);
  const double aside = truth(ran, "probe side").x() - 0.5;
  ASSERT_GT(aside, 0.0015) << "the push was strong enough";
  EXPECT_EQ(ran.report.verdict, Verdict::kError);
  EXPECT_THAT(ran.report.diagnostics, Reports(Code::kConditionNotMet, "/program/steps/2", {"changer"}));
  EXPECT_TRUE(ran.cell().held.empty());
}

TEST(ToolChanges, ALostToolIsNoticedAndItsTcpIsAFault) {
  const Ran ran =
      run_kept(two_tools(kTakeProbe + R"(, {"do": "wait", "seconds": 8},
      {"do": "lin", "name": "without it", "to": {"by_m": [0, 0, 0.02]}, "tool": "probe"})",
                         R"(, "faults": [{"at_s": 8, "do": "tool_changer", "changer": "changer", "fault": "opens"}],
      "expectations": [{"kind": "event", "source": "changer", "event": "lost", "times": 1}])"));
  ASSERT_NE(ran.session, nullptr);
  EXPECT_EQ(ran.report.verdict, Verdict::kError);
  EXPECT_THAT(ran.report.diagnostics, Reports(Code::kNotPossibleNow, "/program/steps/5/tool", {"probe"}));
  EXPECT_FALSE(ran.cell().knows("probe side"));
  EXPECT_EQ(ran.cell().tools.at("probe").arm, "");
  EXPECT_NEAR(load(ran), 0.0, 1e-9);
}

TEST(ToolChanges, FaultsOfTheScenarioNameAChanger) {
  EXPECT_THAT(refusal(two_tools(
                  "", R"(, "faults": [{"at_s": 0, "do": "tool_changer", "changer": "chanjer", "fault": "opens"}])")),
              Reports(Code::kUnknownName, "/faults/0/changer", {"chanjer", "changer"}));
}

}  // namespace
}  // namespace takt::cell::tool_changer_test
