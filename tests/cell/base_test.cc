// A mobile base in whole scenarios: alone, with wrong odometry, and with an arm on top.
#include <algorithm>
#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/build/cell_builder.h"
#include "cell/run/session.h"
#include "core/command/actions/carried_motion.h"
#include "core/command/single_net.h"
#include "core/kinematics/chain.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"

namespace takt::cell::base_test {
namespace {

using takt::test::Expected;
using takt::test::Reports;
using takt::test::ReportsAnywhere;
using test::expect_passed;
using test::models;
using test::parsed;
using test::refusal;
using test::run;
using testing::Not;

Description alone(const std::string& program, const std::string& more = "", const std::string& base = "") {
  return parsed(
      R"({"devices": {"base": {"model": "youbot_base", "at": {"position_m": [1, 2, 0], "rpy_deg": [0, 0, 90]})" + base +
      R"(}}, "frames": {"bay": {"position_m": [1, 3, 0], "rpy_deg": [0, 0, 180]}},
                "program": {"do": "sequence", "steps": [)" +
      program + "]}" + more + "}");
}

Description rolling(const std::string& program, const std::string& more = "") {
  return parsed(R"({"devices": {"base": {"model": "rmp50", "at": {"position_m": [1, 2, 0], "rpy_deg": [0, 0, 90]}}},
                    "program": {"do": "sequence", "steps": [)" +
                program + "]}" + more + "}");
}

/// To its side and turned: it turns, drives, turns. Then ahead, and an arc.
TEST(RollingBase, PtpReachesAPoseBesideItAndLinFollowsItsHeading) {
  expect_passed(run(rolling(R"({"do": "ptp", "to": {"in": "world", "position_m": [2, 2.5, 0], "rpy_deg": [0, 0, 0]}},
      {"do": "lin", "to": {"by_m": [-0.4, 0, 0]}},
      {"do": "circ", "about": {"position_m": [1.6, 3.1, 0], "angle_deg": 60}, "orientation": "tangential"})",
                            R"(, "expectations": [{"kind": "limits"}, {"kind": "tool_pose",
      "position_m": [2.11962, 2.8, 0], "rpy_deg": [0, 0, 60], "position_within_m": 2e-3, "angle_within_deg": 0.2}])")));
}

TEST(RollingBase, WhatGoesSidewaysIsRefusedBeforeAnythingMoves) {
  EXPECT_THAT(refusal(rolling(R"({"do": "lin", "to": {"in": "world", "by_m": [0.3, 0, 0]}})")),
              Reports(Code::kUnsupported, "/program/steps/0/to", {"90"}));
  EXPECT_THAT(
      refusal(rolling(R"({"do": "lin", "to": {"in": "world", "by_m": [0, 0.3, 0], "by_rpy_deg": [0, 0, 30]}})")),
      Reports(Code::kUnsupported, "/program/steps/0/to"));
}

TEST(Base, LinAndPtpGoToPosesInTheRoom) {
  for (const char* how : {"lin", "ptp"}) {
    SCOPED_TRACE(how);
    expect_passed(run(alone(R"({"do": ")" + std::string(how) +
                                R"(", "to": {"in": "bay", "position_m": [-0.4, 0.2, 0], "rpy_deg": [0, 0, -45]}})",
                            R"(, "expectations": [{"kind": "limits"}, {"kind": "tool_pose", "in": "bay",
        "position_m": [-0.4, 0.2, 0], "rpy_deg": [0, 0, -45], "position_within_m": 1e-3, "angle_within_deg": 0.1}])")));
  }
}

/// A sill across its way, that high.
std::string sill(const char* height, const char* half) {
  return std::string(R"(, "objects": {"sill": {"shape": "box", "size_m": [2, 0.02, )") + height +
         R"(], "at": {"in": "world", "position_m": [1, 3, )" + half + "]}}}";
}

TEST(Base, ASillIsNoWayAndWhatIsLowerIs) {
  const char* ahead = R"({"do": "lin", "to": {"in": "world", "by_m": [0, 1.5, 0]}})";
  EXPECT_THAT(refusal(alone(ahead, sill("0.005", "0.0025"))),
              Reports(Code::kCollision, "/program/steps/0", {"sill", "base"}));
  EXPECT_THAT(refusal(rolling(ahead, sill("0.005", "0.0025"))),
              Reports(Code::kCollision, "/program/steps/0", {"sill"}));
  expect_passed(run(alone(ahead, sill("0.0015", "0.00075"))));
}

/// By hand nothing is planned: the wheels meet it, and the base does not pass.
TEST(Base, ASillStopsABaseThatIsDrivenByHand) {
  const std::string switched = R"(, "channels": {"on": {"type": "Boolean", "initial": true}})";
  const auto driven = [&](const char* height, const char* half) {
    const char* jog = R"({"do": "jog", "in": "world", "linear_m_s": [0, 0.1, 0], "seconds": 12,
      "while": {"channel": "on"}})";
    return run(alone(jog, sill(height, half) + switched)).verdict;
  };
  EXPECT_NE(driven("0.005", "0.0025"), Verdict::kPassed);
  EXPECT_EQ(driven("0.0015", "0.00075"), Verdict::kPassed);
}

TEST(Base, AGoalOutOfThePlaneIsAnErrorThatSaysSo) {
  for (const char* how : {"lin", "ptp"}) {
    SCOPED_TRACE(how);
    const std::string step = R"({"do": ")" + std::string(how) + R"(", "to": )";
    EXPECT_THAT(refusal(alone(step + R"({"by_m": [0.1, 0, 0.02]}})")),
                Reports(Code::kUnsupported, "/program/steps/0/to", {"3", "0.02 m", "z"}));
    const Diagnostics tilted =
        refusal(alone(step + R"({"in": "bay", "position_m": [0, 0, 0], "rpy_deg": [5, 0, 0]}})"));
    EXPECT_THAT(tilted, Reports(Code::kUnsupported, "/program/steps/0/to", {"3", "deg"}));
    EXPECT_THAT(tilted, Not(Reports(Code::kUnsupported, "/program/steps/0/to", {"m"}))) << "only what is missing";
  }
}

TEST(Base, AWayOutOfItsRangeIsRefused) {
  const Diagnostics straight = refusal(alone(R"({"do": "lin", "to": {"by_m": [0, 60, 0]}})"));
  ASSERT_TRUE(straight.has_errors());
  EXPECT_THAT(straight.to_string(), takt::test::Names("joint 'x'"));
  EXPECT_TRUE(refusal(alone(R"({"do": "ptp", "to": {"by_m": [0, 60, 0]}})")).has_errors());
}

TEST(Base, ItsSettingsAreChecked) {
  const std::string at = "/devices/base";
  const std::pair<const char*, Expected> mistakes[] = {
      {R"(, "settings": {"odometry": {"linear_scale": 3}})",
       {Code::kOutOfRange, at + "/settings/odometry/linear_scale", {"3"}}},
      {R"(, "settings": {"odometry": {"drift": 3}})",
       {Code::kUnknownKey, at + "/settings/odometry/drift", {"linear_scale", "angular_scale"}}},
      {R"(, "settings": {"odometri": {}})", {Code::kUnknownKey, at + "/settings/odometri", {"odometry"}}},
      {R"(, "start_deg": [0, 0, 0])", {Code::kInvalidValue, at + "/start_deg"}}};
  for (const auto& [base, expected] : mistakes) {
    EXPECT_THAT(refusal(alone(R"({"do": "wait", "seconds": 0.1})", "", base)), Reports(expected));
  }
}

/// It ends where it believes; where it is shows in the truth alone.
TEST(Base, WrongOdometryMissesTheGoalByAsMuchAsItIsWrong) {
  const std::string wrong = R"(, "settings": {"odometry": {"linear_scale": 1.05}})";
  const auto report = run(alone(R"({"do": "lin", "to": {"by_m": [0, 1, 0]}})",
                                R"(, "expectations": [
      {"name": "where it wanted to be", "kind": "tool_pose", "position_m": [1, 3, 0], "position_within_m": 0.02},
      {"name": "where it is", "kind": "tool_pose", "position_m": [1, 2.95238, 0], "position_within_m": 0.002}])",
                                wrong));
  ASSERT_EQ(report.expectations.size(), 2u) << report.diagnostics.to_string();
  EXPECT_FALSE(report.expectations[0].passed) << report.expectations[0].measured;
  EXPECT_TRUE(report.expectations[1].passed) << report.expectations[1].measured;
}

// -- With an arm on top
// ------------------------------------------------------------------------------------------------

Description mounted(const std::string& program, const std::string& more = "") {
  return parsed(R"({"devices": {"base": {"model": "youbot_base"}, "arm": {"model": "lwr4plus", "on": "base"},
                "probe": {"model": "probe_ball", "on": "arm"}}, "composed": {"robot": ["base", "arm"]},
                "program": {"do": "sequence", "steps": [)" +
                program + "]}" + more + "}");
}

/// The same place in the room from two places of the base, which turns in between.
TEST(ArmOnBase, GoalsInTheRoomAreReachedFromWhereverTheBaseStands) {
  const std::string pose = R"("position_m": [0.75, 0.15, 0.55], "rpy_deg": [0, 180, 0])";
  expect_passed(run(mounted(R"({"do": "ptp", "arm": "arm", "to": {"in": "world", )" + pose + R"(}},
      {"do": "ptp", "arm": "arm", "to": "home"},
      {"do": "lin", "arm": "base", "to": {"in": "world", "position_m": [0.15, 0.5, 0], "rpy_deg": [0, 0, -40]}},
      {"do": "lin", "arm": "arm", "to": {"by_m": [0, 0, 0.1]}},
      {"do": "ptp", "arm": "arm", "to": {"in": "world", )" +
                                pose + R"(}})",
                            R"(, "expectations": [{"kind": "tool_pose", "arm": "arm", )" + pose +
                                R"(, "position_within_m": 0.002, "angle_within_deg": 0.3},
      {"kind": "tool_pose", "arm": "base", "position_m": [0.15, 0.5, 0], "rpy_deg": [0, 0, -40],
       "position_within_m": 0.002, "angle_within_deg": 0.2}, {"kind": "limits", "arm": "arm"}])")));
}

/// Out of reach from where the base will stand: found before anything moves.
TEST(ArmOnBase, TheRehearsalKnowsWhereTheBaseWillStand) {
  const std::string reach = R"({"do": "ptp", "arm": "arm", "to": {"in": "world", "position_m": [0.75, 0, 0.55],
                                "rpy_deg": [0, 180, 0]}})";
  EXPECT_TRUE(refusal(mounted(reach)).empty());
  EXPECT_THAT(refusal(mounted(R"({"do": "lin", "arm": "base", "to": {"by_m": [-1, 0, 0]}}, )" + reach)),
              Reports(Code::kUnreachable, "/program/steps/1/to"));
}

TEST(ArmOnBase, PartAndWholeAtOnceAreAConflictAtLoad) {
  const auto nets = [](const char* second) {
    return mounted(R"({"do": "net", "net": "both"})", R"(, "nets": {"both": {"primitives": [
      {"id": "whole", "type": "Reservation", "parameters": {"device": "robot"}},
      {"id": "base", "type": "ArmCommand", "parameters": {"device": ")" +
                                                          std::string(second) + R"("}}],
      "links": []}})");
  };
  EXPECT_THAT(refusal(nets("base")), ReportsAnywhere(Code::kResourceConflict, {"whole", "robot", "base"}));
}

/// How far a point is from the line between two others, m.
double off_line(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = (b - a).normalized();
  return (p - a - along.dot(p - a) * along).norm();
}

/// In set points and with physics: the probe of an arm goes a metre straight ahead while the base below drives another
/// way and turns. Figures: docs/benchmarks.md.
TEST(ArmOnBase, TheToolGoesStraightInTheRoomWhileTheBaseDrivesAndTurns) {
  const Description description = mounted(R"({"do": "wait", "seconds": 1})");
  Diagnostics warnings;
  auto built = build_cell(description, models(), false, warnings);
  ASSERT_TRUE(built) << built.error().to_string();
  const auto cycle = [&] {
    built->core->step();
    ASSERT_TRUE(built->world->step());
  };
  for (int k = 0; k < 100; ++k) cycle();

  expression::Cell& cell = built->cell;
  const expression::MountedArm &base = cell.arms.at("base"), &arm = cell.arms.at("arm");
  const Eigen::Isometry3d X_FA = cell.frames.relation("arm")->X_PF;
  const auto set_point = [&] {
    return Eigen::Isometry3d(base.device->description().chain->forward(base.device->set_point().q) * X_FA *
                             arm.device->description().chain->forward(arm.device->set_point().q) * arm.X_FT);
  };
  const Eigen::Isometry3d X_start = set_point();
  Eigen::Isometry3d X_goal = X_start;
  X_goal.translation() += Eigen::Vector3d(0.9, 0.4, 0.1);
  kinematics::JointVector q_goal(3);
  q_goal << 0.8, 0.6, -0.5;
  const auto motion =
      command::carried_lin(cell, "arm", {base.device->set_point().q, arm.device->set_point().q, q_goal, X_goal});
  ASSERT_TRUE(motion) << motion.error().to_string();
  const command::RuntimeCommand moved("straight", command::arm_on_base(cell, "arm"), command::planned(*motion));
  const auto id = built->core->load(command::single_net(moved, "straight").value().net);
  ASSERT_TRUE(id) << id.error().to_string();
  built->core->start(*id);
  cycle();
  double told = 0.0, tracked = 0.0;
  int cycles = 0;
  const int probe = built->world->body("probe/tcp");
  for (; built->core->state(*id) != rcc::NetState::kTerminated && cycles < 20'000; ++cycles) {
    cycle();
    told = std::max(told, off_line(set_point().translation(), X_start.translation(), X_goal.translation()));
    tracked = std::max(
        tracked, off_line(built->world->body_pose(probe).translation(), X_start.translation(), X_goal.translation()));
  }
  RecordProperty("told_nm", static_cast<int>(told * 1e9));
  RecordProperty("tracked_um", static_cast<int>(tracked * 1e6));
  std::printf("off its line: told %.3g m, tracked %.3g m, %d cycles\n", told, tracked, cycles);
  EXPECT_LT((set_point().translation() - X_goal.translation()).norm(), 1e-9);
  EXPECT_NEAR(base.device->set_point().q[2], -0.5, 1e-12);
  EXPECT_LT(told, 1e-6);
  EXPECT_LT(tracked, 2e-3);
}

TEST(ArmOnBase, MistakesOfAMotionWithTheBaseAreFindings) {
  const std::string to = R"("to": {"by_m": [0.1, 0, 0]})";
  const std::string at = "/program/steps/0";
  const std::pair<std::string, Expected> mistakes[] = {
      {R"("base_to": {"by_m": [0, 0, 0.1]})", {Code::kUnsupported, at + "/base_to", {"3", "z"}}},
      {R"("base_to": {"by_m": [3, 0, 0]})", {Code::kUnreachable, at + "/to"}},
      {R"("base_to": {"by_m": [0.1, 0, 0]}, "blend_m": 0.1)", {Code::kConflict, at + "/blend_m"}},
      {R"("base_to": {"by_m": [0.1, 0, 0]}, "weave": {"amplitude_m": 0.001, "frequency_Hz": 2})",
       {Code::kConflict, at + "/weave", {"weave"}}},
      {R"("base_to": {"in": "nowhere", "position_m": [0, 0, 0]})", {Code::kUnknownName, at + "/base_to", {"nowhere"}}}};
  for (const auto& [base, expected] : mistakes)
    EXPECT_THAT(refusal(mounted(R"({"do": "lin", "arm": "arm", )" + to + ", " + base + "}")), Reports(expected));
  EXPECT_THAT(refusal(mounted(R"({"do": "lin", "arm": "base", )" + to + R"(, "base_to": {"by_m": [0.1, 0, 0]}})")),
              Reports(Code::kRequires, at + "/arm", {"base"}));
}

/// As a command of a transaction; the motion after it knows where the base stands by then.
TEST(ArmOnBase, InATransactionTheToolGoesStraightAndGoalsInTheRoomAreReached) {
  expect_passed(run(mounted(R"({"do": "ptp", "arm": "arm", "to": {"in": "world", "position_m": [0.75, 0.15, 0.55],
                                "rpy_deg": [0, 180, 0]}},
      {"do": "transaction", "name": "t", "commands": {
         "straight": {"do": "lin", "start": true, "arm": "arm", "to": {"in": "world", "position_m": [1.05, 0.45, 0.55]},
                      "base_to": {"by_m": [0.3, 0.4, 0], "by_rpy_deg": [0, 0, 20]}},
         "reach": {"do": "ptp", "arm": "arm", "to": {"in": "world", "position_m": [1.0, 0.45, 0.6],
                   "rpy_deg": [0, 180, 0]}}},
       "on": [{"entered": {"completed": "straight"}, "start": "reach"}]})",
                            R"(, "expectations": [{"kind": "limits", "arm": "arm"}, {"kind": "limits", "arm": "base"},
      {"kind": "tool_pose", "arm": "arm", "position_m": [1.0, 0.45, 0.6], "rpy_deg": [0, 180, 0],
       "position_within_m": 0.003, "angle_within_deg": 0.3}])")));
}

/// The base has turned by a quarter before the press begins: the room's axes are others to the arm by then.
TEST(ArmOnBase, APressInTheRoomKnowsHowTheBaseStandsByThen) {
  expect_passed(run(parsed(R"({"devices": {"base": {"model": "youbot_base"}, "arm": {"model": "lwr4plus", "on": "base"},
      "wrist": {"model": "ft_gamma", "on": "arm"}}, "program": {"do": "sequence", "steps": [
      {"do": "ptp", "arm": "arm", "to": {"in": "arm", "position_m": [0.5, 0, 0.5], "rpy_deg": [0, 180, 0]}},
      {"do": "tare", "sensor": "wrist"},
      {"do": "transaction", "name": "t", "commands": {
         "turn": {"do": "lin", "start": true, "arm": "base", "to": {"by_m": [0, 0, 0], "by_rpy_deg": [0, 0, 90]}},
         "feel": {"do": "press", "arm": "arm", "sensor": "wrist", "direction": [1, 0, 0], "in": "world",
                  "approach_m_s": 0.02, "travel_m": 0.3}},
       "on": [{"entered": {"completed": "turn"}, "start": "feel"},
              {"entered": {"started": "feel"}, "after_s": 3, "cancel": "feel"}]},
      {"do": "wait", "seconds": 0.2}]},
      "expectations": [{"kind": "limits", "arm": "arm"},
      {"kind": "tool_pose", "arm": "arm", "position_m": [0.06, 0.643, 0.6275], "rpy_deg": [0, 180, 90],
       "position_within_m": 0.005, "angle_within_deg": 0.5}]})")));
}

/// Both move at once, each by its own step.
TEST(ArmOnBase, BaseAndArmMoveAtTheSameTimeByPart) {
  expect_passed(run(mounted(R"({"do": "parallel", "branches": [
      {"do": "lin", "arm": "base", "to": {"by_m": [0.4, 0.2, 0]}},
      {"do": "ptp", "arm": "arm", "to": {"in": "arm", "position_m": [0.4, 0.1, 0.6], "rpy_deg": [0, 150, 0]}}]})",
                            R"(, "expectations": [{"kind": "limits", "arm": "arm"}, {"kind": "limits", "arm": "base"},
      {"kind": "tool_pose", "arm": "arm", "position_m": [0.943, 0.3, 0.7275], "rpy_deg": [0, 150, 0],
       "position_within_m": 0.002, "angle_within_deg": 0.3}])")));
}

}  // namespace
}  // namespace takt::cell::base_test
