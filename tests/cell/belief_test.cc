// What a program believes of its cell, in whole runs: parts that are carried and lost, frames that ride, tools by name.
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "core/device/arm.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"

namespace takt::cell::belief_test {
namespace {

using takt::test::Reports;
using test::expect_passed;
using test::models;
using test::parsed;
using test::Ran;
using test::refusal;
using test::run_kept;

Description shipped(const std::string& name, const std::vector<Override>& overrides = {}) {
  auto description = read_description("scenarios/" + name, overrides);
  if (!description) {
    ADD_FAILURE() << description.error().to_string();
    return {};
  }
  std::erase_if(description->expectations, [](const auto& one) { return one.kind == "repeats"; });
  return std::move(*description);
}

/// kg, as its controller was told.
double load_of(const expression::Cell& cell, const std::string& arm) {
  return cell.arms.find(arm)->second.device->tool().payload.mass;
}

/// An arm with a gripper, a table, and a block of 0.5 kg on it; `steps` after the block was gripped.
Description with_block(const std::string& steps, const std::string& more = "") {
  return parsed(R"({"devices": {
      "arm": {"model": "lwr4plus", "at": {"position_m": [0, 0, 0.4]}}, "gripper": {"model": "wsg50", "on": "arm"}},
    "objects": {
      "table": {"shape": "box", "size_m": [0.6, 0.9, 0.4], "at": {"position_m": [0.6, 0, 0.2]}},
      "block": {"shape": "box", "size_m": [0.04, 0.04, 0.06], "at": {"in": "table", "position_m": [-0.05, 0, 0.23]},
                "fixed": false, "mass_kg": 0.5,
                "grasps": {"top": {"position_m": [0, 0, 0.01], "rpy_deg": [0, 180, 0]}}}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": {"in": "block/top", "position_m": [0, 0, -0.1], "rpy_deg": [0, 0, 0]}, "speed": 0.6},
      {"do": "lin", "to": {"in": "block/top", "position_m": [0, 0, 0]}, "speed": 0.5},
      {"do": "grip", "name": "grip", "force_N": 60, "speed_m_s": 0.1},
      )" + steps +
                "]}" + more + "}");
}

// -- Parts that are carried -------------------------------------------------------------------------------------------

TEST(BelievedParts, GoOnBeingWhereTheyAreBelievedThroughTenFastMotions) {
  const Ran ran = run_kept(shipped("shake.json"));
  ASSERT_NE(ran.session, nullptr);
  expect_passed(ran.report);
  EXPECT_EQ(ran.cell().held.at("gripper").object, "part") << "nobody named it: it was between the fingers";
  const double empty = ran.cell().arms.at("arm").unloaded->mass;
  EXPECT_NEAR(load_of(ran.cell(), "arm") - empty, 1.0, 0.02) << "what the controller was told";
}

/// Goals on a held part see it where it is: this one asks for where the tool is already.
TEST(BelievedParts, AGoalOnAHeldPartIsWhereTheArmHoldsIt) {
  const Ran ran = run_kept(with_block(R"({"do": "lin", "to": {"by_m": [0, 0, 0.16]}, "speed": 0.5},
      {"do": "lin", "name": "stay", "to": {"in": "block/top", "position_m": [0, 0, 0]}})",
                                      R"(, "expectations": [
      {"kind": "belief", "frame": "block", "position_within_m": 0.002, "angle_within_deg": 1},
      {"kind": "tool_pose", "in": "block/top", "position_within_m": 0.002, "angle_within_deg": 1}])"));
  ASSERT_NE(ran.session, nullptr);
  expect_passed(ran.report);
  EXPECT_NEAR(ran.cell().frames.pose("block")->translation().z(), 0.59, 0.002) << "as high as it is held";
}

TEST(BelievedParts, StayWhereTheyAreReleasedAndCanBeGrippedAgain) {
  const Ran ran = run_kept(with_block(R"({"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "speed": 0.5},
      {"do": "lin", "to": {"by_m": [0.02, 0.25, 0]}, "speed": 0.5},
      {"do": "lin", "to": {"by_m": [0, 0, -0.0995]}, "velocity_m_s": 0.05},
      {"do": "release", "width_m": 0.08, "speed_m_s": 0.1},
      {"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "speed": 0.5},
      {"do": "ptp", "to": "home", "speed": 0.5},
      {"do": "ptp", "to": {"in": "block/top", "position_m": [0, 0, -0.1], "rpy_deg": [0, 0, 0]}, "speed": 0.6},
      {"do": "lin", "to": {"in": "block/top", "position_m": [0, 0, 0]}, "speed": 0.5},
      {"do": "grip", "force_N": 60, "speed_m_s": 0.1, "part": "block", "part_mass_kg": 0.5},
      {"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "speed": 0.5})",
                                      R"(, "expectations": [{"kind": "gripper", "is": "holding"},
      {"kind": "belief", "frame": "block", "position_within_m": 0.002, "angle_within_deg": 1}])"));
  ASSERT_NE(ran.session, nullptr);
  expect_passed(ran.report);
}

/// The gripper closes 4 mm beside the middle of the block, along its fingers and across them: those push it back, but
/// only along their way.
TEST(BelievedParts, AreWhereClosingFingersPushThem) {
  const Ran ran = run_kept(with_block(R"({"do": "release", "width_m": 0.07, "speed_m_s": 0.1},
      {"do": "lin", "name": "beside it", "to": {"by_m": [0.004, 0.004, 0]}, "velocity_m_s": 0.02},
      {"do": "grip", "name": "again", "force_N": 60, "speed_m_s": 0.05},
      {"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "speed": 0.5})",
                                      R"(, "expectations": [{"kind": "gripper", "is": "holding"},
      {"kind": "belief", "frame": "block", "position_within_m": 0.001, "angle_within_deg": 0.5}])"));
  ASSERT_NE(ran.session, nullptr);
  expect_passed(ran.report);
  const Eigen::Vector3d p = ran.cell().frames.pose("block")->translation();
  const Eigen::Vector2d moved(p.x() - 0.55, p.y());
  EXPECT_NEAR(std::max(std::abs(moved.x()), std::abs(moved.y())), 0.004, 2e-4) << "along the way of the fingers";
  EXPECT_NEAR(std::min(std::abs(moved.x()), std::abs(moved.y())), 0.0, 2e-4) << "across it";
}

TEST(BelievedParts, WhatIsReleasedRidesOnWhatItLiesOn) {
  const Ran ran = run_kept(with_block(R"({"do": "lin", "to": {"by_m": [0, 0, 0.05]}, "speed": 0.5},
      {"do": "lin", "to": {"by_m": [0, 0, -0.0495]}, "velocity_m_s": 0.05},
      {"do": "release", "width_m": 0.08, "speed_m_s": 0.1})"));
  ASSERT_NE(ran.session, nullptr);
  EXPECT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  EXPECT_EQ(ran.cell().frames.relation("block")->parent, "table");
  EXPECT_DOUBLE_EQ(load_of(ran.cell(), "arm"), ran.cell().arms.at("arm").unloaded->mass) << "put down";
}

TEST(BelievedParts, AreLostWhenTheyAreKnockedOutOfTheHand) {
  const Ran ran =
      run_kept(with_block(R"({"do": "lin", "to": {"by_m": [0, 0, 0.2]}, "speed": 0.5},
      {"do": "wait", "seconds": 6},
      {"do": "lin", "name": "after it", "to": {"in": "block", "position_m": [0, 0, 0.1]}})",
                          R"(, "faults": [{"do": "push", "at_s": 5, "body": "block", "force_N": [0, 0, -400],
      "seconds": 0.5}])"));
  ASSERT_NE(ran.session, nullptr);
  EXPECT_EQ(ran.report.verdict, Verdict::kError);
  EXPECT_THAT(ran.report.diagnostics, Reports(Code::kUnknownPose, "/program/steps/5/to", {"block"}));
  EXPECT_FALSE(ran.cell().knows("block"));
  EXPECT_TRUE(ran.cell().held.empty());
}

// -- Masses that programs say -----------------------------------------------------------------------------------------

TEST(ToldMasses, ThatDoNotFitTheObjectAreErrors) {
  EXPECT_THAT(refusal(shipped("pick.json", {{"/objects/part/mass_kg", "2"}})),
              Reports(Code::kPayloadMismatch, "/program/steps/2/part_mass_kg", {"part", "2", "1"}));
  EXPECT_THAT(refusal(shipped("pick.json", {{"/program/steps/2/part_mass_kg", "1.5"}})),
              Reports(Code::kPayloadMismatch, "/program/steps/2/part_mass_kg", {"part", "1", "1.5"}));
  EXPECT_TRUE(refusal(shipped("pick.json", {{"/program/steps/2/part_mass_kg", "1.01"}})).empty()) << "within 2 %";
}

/// Each arm says its half.
TEST(ToldMasses, OfTwoArmsAddUp) {
  EXPECT_FALSE(refusal(shipped("carry.json")).has_errors());
  EXPECT_THAT(refusal(shipped("carry.json", {{"/objects/bar/mass_kg", "2"}})),
              Reports(Code::kPayloadMismatch, "/program/steps/3/branches/0/part_mass_kg", {"bar", "2", "1"}));
}

TEST(ToldMasses, AFixedObjectCannotBeTaken) {
  EXPECT_THAT(refusal(shipped("pick.json", {{"/program/steps/2/part", "box"}})),
              Reports(Code::kConflict, "/program/steps/2/part", {"box"}));
}

// -- Frames that ride -------------------------------------------------------------------------------------------------

/// A part in a tray on a platform that drives up to an arm.
TEST(BelievedFrames, OnABaseMoveWithItAndSoDoWhatStandsOnThemAndCameras) {
  const Ran ran = run_kept(parsed(R"({"devices": {
      "platform": {"model": "youbot_base", "at": {"position_m": [1, -1, 0]}}},
    "frames": {"beside": {"in": "platform", "position_m": [0, 0.5, 0.2]}},
    "objects": {
      "tray": {"shape": "box", "size_m": [0.2, 0.25, 0.02], "at": {"in": "platform", "position_m": [-0.15, 0, 0.1375]},
               "fixed": false, "mass_kg": 0.6},
      "bolt": {"shape": "box", "size_m": [0.03, 0.03, 0.03], "at": {"in": "tray", "position_m": [0.03, 0, 0.025]},
               "fixed": false, "mass_kg": 0.1}},
    "cameras": {"mast": {"at": {"in": "platform", "position_m": [0.2, 0, 1]}, "look_at": {"in": "tray"}}},
    "program": {"do": "sequence", "steps": [
      {"do": "lin", "arm": "platform", "to": {"by_m": [0.3, 0.5, 0], "by_rpy_deg": [0, 0, 60]}}]},
    "expectations": [
      {"kind": "belief", "frame": "bolt", "position_within_m": 0.002, "angle_within_deg": 1},
      {"kind": "belief", "frame": "beside", "position_within_m": 0.002, "angle_within_deg": 1},
      {"kind": "object_pose", "object": "bolt", "in": "tray", "position_m": [0.03, 0, 0.025],
       "position_within_m": 0.001}]
    })"));
  ASSERT_NE(ran.session, nullptr);
  expect_passed(ran.report);
  const auto X = ran.cell().frames.pose("beside");
  ASSERT_TRUE(X.has_value());
  EXPECT_NEAR(X->translation().x(), 1.3 - 0.5 * std::sin(M_PI / 3), 0.002);
  EXPECT_NEAR(X->translation().y(), -0.5 + 0.5 * std::cos(M_PI / 3), 0.002);
}

/// An arm above a table with a lamp on its forearm, and a frame on its upper arm.
Description with_lamp(const std::string& goal_deg) {
  return parsed(R"({"devices": {"arm": {"model": "lwr4plus", "at": {"position_m": [0, 0, 0]}}},
    "frames": {"mark": {"in": "arm/link3", "position_m": [0, 0.15, 0.05]}},
    "objects": {
      "table": {"shape": "box", "size_m": [0.4, 1.2, 0.05], "at": {"in": "world", "position_m": [0.6, 0, -0.025]}},
      "lamp": {"shape": "box", "size_m": [0.04, 0.04, 0.04], "at": {"in": "arm/link5", "position_m": [0, 0, 0.3]}}},
    "collisions": {"allow": [{"between": ["lamp", "arm"], "reason": "it is screwed on"}]},
    "cameras": {"shoulder": {"at": {"in": "arm/link2", "position_m": [0, 0, 0.3]}, "look_at": {"in": "arm/flange"}}},
    "program": {"do": "sequence", "steps": [{"do": "ptp", "name": "go", "to": {"joints_deg": [)" +
                goal_deg + R"(]}}]},
    "expectations": [
      {"kind": "belief", "frame": "mark", "position_within_m": 0.001, "angle_within_deg": 0.1},
      {"kind": "belief", "frame": "lamp", "position_within_m": 0.001, "angle_within_deg": 0.1}]
    })");
}

TEST(BelievedFrames, OnALinkMoveWithItAndSoDoesWhatIsFixedThere) {
  const Ran ran = run_kept(with_lamp("40, -20, 30, 70, 20, -60, 0"));
  ASSERT_NE(ran.session, nullptr);
  expect_passed(ran.report);
  const auto before = Session::create(with_lamp("40, -20, 30, 70, 20, -60, 0"), models());
  ASSERT_TRUE(before);
  for (const char* frame : {"mark", "lamp", "arm/link3"}) {
    const auto was = (*before)->built().cell.frames.pose(frame), is = ran.cell().frames.pose(frame);
    ASSERT_TRUE(was && is) << frame;
    EXPECT_GT((was->translation() - is->translation()).norm(), 0.01) << frame;
  }
}

TEST(BelievedFrames, WhatIsFixedToALinkCollidesWhereTheLinkTakesIt) {
  EXPECT_THAT(refusal(with_lamp("0, -100, 0, 60, 0, 0, 0")),
              takt::test::ReportsAnywhere(Code::kCollision, {"lamp", "table"}));
}

TEST(BelievedFrames, AStepMakesThemAndTheyDependOnWhatItSays) {
  const Ran ran = run_kept(with_block(R"({"do": "set_frame", "as": "before", "of": "gripper/tcp", "in": "table"},
      {"do": "set_frame", "as": "under", "in": "block", "position_m": [0, 0, -0.03]},
      {"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "speed": 0.5})"));
  ASSERT_NE(ran.session, nullptr);
  EXPECT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  EXPECT_NEAR(ran.cell().frames.pose("before")->translation().z(), 0.44, 1e-3) << "where the tool was";
  EXPECT_NEAR(ran.cell().frames.pose("under")->translation().z(), 0.5, 1e-3) << "under the block, that is carried";
  EXPECT_THAT(refusal(with_block(R"({"do": "set_frame", "as": "table"})")),
              Reports(Code::kInvalidName, "/program/steps/3/as", {"table"}));
  EXPECT_THAT(refusal(with_block(R"({"do": "set_frame", "as": "x", "in": "tabel"})")),
              Reports(Code::kUnknownName, "/program/steps/3/in", {"tabel", "table"}));
}

/// A program that has measured by its own means: what the object carries comes along, and what it stands on stays.
TEST(BelievedFrames, AStepSaysWhereAnObjectHasBeenFound) {
  const Ran ran = run_kept(parsed(R"({"devices": {"platform": {"model": "youbot_base"}},
    "objects": {
      "tray": {"shape": "box", "size_m": [0.3, 0.2, 0.02], "at": {"in": "platform", "position_m": [0, 0, 0.4]},
               "vary": {"position_m": [0.02, 0.02, 0]}, "fixed": false, "mass_kg": 0.6},
      "bolt": {"shape": "box", "size_m": [0.03, 0.03, 0.03], "at": {"in": "tray", "position_m": [0.03, 0, 0.025]},
               "fixed": false, "mass_kg": 0.1},
      "deck": {"shape": "box", "size_m": [0.4, 0.3, 0.1], "at": {"in": "platform", "position_m": [0, 0, 0.34]}}},
    "program": {"do": "sequence", "steps": [
      {"do": "set_frame", "as": "tray", "in": "platform", "position_m": [0.01, -0.02, 0.4], "rpy_deg": [0, 0, 5]},
      {"do": "lin", "arm": "platform", "to": {"by_m": [0.2, 0, 0]}}]}})"));
  ASSERT_NE(ran.session, nullptr);
  EXPECT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  const auto tray = ran.cell().frames.pose("tray"), bolt = ran.cell().frames.pose("bolt");
  ASSERT_TRUE(tray && bolt);
  EXPECT_NEAR(tray->translation().x(), 0.21, 1e-3) << "it rode on";
  EXPECT_NEAR(tray->translation().y(), -0.02, 1e-3);
  EXPECT_NEAR(bolt->translation().y(), -0.02 + 0.03 * std::sin(5 * M_PI / 180), 1e-3) << "in the tray";
}

// -- The arm's own force ----------------------------------------------------------------------------------------------

/// A push of 20 N is felt by the joints, within what an arm knows of itself.
TEST(OwnForce, OfAnArmEndsAGuardedMotionAsASensorDoes) {
  const Ran ran = run_kept(parsed(R"({"devices": {"arm": {"model": "lwr4plus", "own_force": "felt"},
      "probe": {"model": "probe_ball", "on": "arm"}},
    "objects": {"block": {"shape": "box", "size_m": [0.2, 0.2, 0.2], "at": {"position_m": [0.5, 0, 0.1]}}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.13], "rpy_deg": [0, 180, 0]}},
      {"do": "tare", "sensor": "felt"},
      {"do": "lin", "to": {"by_m": [0, 0, -0.06]}, "velocity_m_s": 0.01, "until": {"sensor": "felt", "above_N": 10}},
      {"do": "lin", "to": {"by_m": [0, 0, 0.02]}}]},
    "expectations": [{"kind": "contact_force", "between": ["probe", "block"], "below_N": 25, "at_least_N": 5}]})"));
  ASSERT_NE(ran.session, nullptr);
  expect_passed(ran.report);
}

// -- Tools by name ----------------------------------------------------------------------------------------------------

/// Two tools at angles; the gripper has a second tool centre point.
Description with_tools(const std::string& arm, const std::string& steps, const std::string& more = "") {
  return parsed(R"({"devices": {"arm": {"model": "lwr4plus")" + arm + R"(},
      "gripper": {"model": "wsg50", "on": "arm", "mount": {"position_m": [0.04, 0, 0], "rpy_deg": [0, 20, 0]},
                  "tcps": {"tip": {"position_m": [0, 0, 0.2]}}},
      "probe": {"model": "probe_ball", "on": "arm", "mount": {"position_m": [-0.04, 0, 0], "rpy_deg": [0, -30, 0]}}},
    "program": {"do": "sequence", "steps": [)" +
                steps + "]}" + more + "}");
}

TEST(Tools, WithoutADeclaredDefaultAreAnErrorThatSaysWhatToWrite) {
  EXPECT_THAT(refusal(with_tools("", R"({"do": "ptp", "to": "home"})")),
              Reports(Code::kMissing, "/devices/arm/tool", {"gripper", "probe", "arm"}));
  EXPECT_THAT(refusal(with_tools(R"(, "tool": "prob")", R"({"do": "ptp", "to": "home"})")),
              Reports(Code::kUnknownName, "/devices/arm/tool", {"prob", "probe"}));
}

TEST(Tools, OfAStepCountForItsGoalAndTheDefaultForTheNext) {
  const std::string goal = R"("to": {"in": "world", "position_m": [0.5, 0, 0.3], "rpy_deg": [0, 180, 0]})";
  for (const auto& [tool, frame] : {std::pair("", "probe/tcp"),
                                    {R"("tool": "gripper", )", "gripper/tcp"},
                                    {R"("tool": "gripper", "tcp": "tip", )", "gripper/tip"},
                                    {R"("tcp": "gripper/tip", )", "gripper/tip"}}) {
    SCOPED_TRACE(frame);
    const Ran ran = run_kept(with_tools(R"(, "tool": "probe")", R"({"do": "ptp", )" + std::string(tool) + goal + "}",
                                        R"(, "collisions": {"off": "the tools stand close to the wrist"})"));
    ASSERT_NE(ran.session, nullptr);
    EXPECT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
    const auto X = ran.cell().frames.pose(frame);
    ASSERT_TRUE(X.has_value());
    EXPECT_LT((X->translation() - Eigen::Vector3d(0.5, 0, 0.3)).norm(), 1e-3);
    const Eigen::Isometry3d X_FT = ran.cell().frames.pose(frame, "arm/flange").value();
    EXPECT_TRUE(ran.cell().arms.at("arm").device->tool().X_FT.isApprox(X_FT, 1e-9)) << "its controller was told";
  }
}

TEST(Tools, ThatAreNotThereAreErrorsAtTheirKey) {
  const auto step = [](const std::string& tool) {
    return with_tools(R"(, "tool": "probe")", R"({"do": "lin", )" + tool + R"(, "to": {"by_m": [0, 0, 0.05]}})");
  };
  EXPECT_THAT(refusal(step(R"("tool": "griper")")), Reports(Code::kUnknownName, "/program/steps/0/tool", {"gripper"}));
  EXPECT_THAT(refusal(step(R"("tcp": "tip")")), Reports(Code::kUnknownName, "/program/steps/0/tcp", {"tip"}));
  EXPECT_THAT(refusal(step(R"("tcp": "arm")")), Reports(Code::kUnknownPose, "/program/steps/0/tcp", {"arm"}));
}

TEST(Tools, OneForAnArmInATransaction) {
  const auto lin = [](const std::string& more) {
    return R"({"do": "lin", "to": {"by_m": [0, 0, 0.05]}, )" + more + "}";
  };
  const std::string apart = R"({"do": "transaction", "commands": {"a": )" + lin(R"("start": true, "tool": "gripper")") +
                            R"(, "b": )" + lin(R"("tool": "probe")") +
                            R"(}, "on": [{"entered": {"completed": "a"}, "start": "b"}]})";
  EXPECT_THAT(refusal(with_tools(R"(, "tool": "probe")", apart)),
              Reports(Code::kConflict, "/program/steps/0/commands/b/tool", {"arm"}));
  const std::string blended = R"({"do": "transaction", "commands": {"m": {"do": "motions", "start": true, "steps": [)" +
                              lin(R"("tool": "gripper", "blend_m": 0.01)") + ", " + lin(R"("tool": "probe")") + "]}}}";
  EXPECT_THAT(refusal(with_tools(R"(, "tool": "probe")", blended)),
              Reports(Code::kConflict, "/program/steps/0/commands/m/steps/1/tool"));
}

}  // namespace
}  // namespace takt::cell::belief_test
