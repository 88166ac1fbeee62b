// The operation `move`: ways around obstacles, in files (docs/planning.md). Whether a path is free is judged by the
// rehearsal's check of the timed motion, which knows nothing of the search.
#include <algorithm>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"
#include "tests/support/scenario_names.h"

namespace takt::cell::move_test {
namespace {

using takt::test::Notes;
using takt::test::Reports;
using takt::test::ReportsAnywhere;
using test::models;
using test::parsed;
using ::testing::Not;

/// What its rehearsal says.
Diagnostics rehearsed(const std::string& text) {
  auto session = Session::create(parsed(text), models());
  return session ? (*session)->warnings() : session.error();
}

/// An LWR with a gripper half a metre above the floor, a table, and a post that a turn of the first joint drives it
/// into.
std::string cell_with(const std::string& steps, const std::string& objects = "") {
  return fmt::format(R"({{"devices": {{
      "arm": {{"model": "lwr4plus", "at": {{"in": "room"}}}},
      "gripper": {{"model": "wsg50", "on": "arm"}}}},
      "frames": {{"room": {{"in": "world", "position_m": [0, 0, 0.5]}}}}, "objects": {{
      "table": {{"shape": "box", "size_m": [0.8, 1.4, 0.05], "at": {{"in": "room", "position_m": [0.7, 0, -0.1]}}}},
      "post": {{"shape": "box", "size_m": [0.05, 0.05, 1.2],
                "at": {{"in": "room", "position_m": [0.4, 0.4, 0.53]}}}}{}}},
      "program": {{"do": "sequence", "steps": [{}]}}}})",
                     objects, steps);
}

const std::string kRight = R"({"do": "ptp", "name": "right", "to": {"joints_deg": [0, -30, 0, 90, 0, -60, 0]}}, )";
std::string to_the_left(const std::string& word, const std::string& more = "") {
  return fmt::format(R"({{"do": "{}", "name": "left", "to": {{"joints_deg": [90, -30, 0, 90, 0, -60, 0]}}{}}})", word,
                     more);
}

TEST(Move, GoesAroundWhatAPtpIsDrivenInto) {
  EXPECT_THAT(rehearsed(cell_with(kRight + to_the_left("ptp"))),
              Reports(Code::kCollision, "/program/steps/1", {"post", "left"}));
  EXPECT_THAT(rehearsed(cell_with(kRight + to_the_left("move"))), Not(ReportsAnywhere(Code::kCollision)));
  EXPECT_THAT(rehearsed(cell_with(kRight + to_the_left("move", R"(, "seed": 7, "clearance_m": 0.02)"))),
              Not(ReportsAnywhere(Code::kCollision)));
}

TEST(Move, IsBlendedWithItsNeighbours) {
  const std::string up = R"({"do": "lin", "name": "up", "to": {"by_m": [0, 0, 0.1]}, "blend_m": 0.02}, )";
  const std::string down = R"(, {"do": "lin", "name": "down", "to": {"by_m": [0, 0, -0.1]}})";
  const Diagnostics said = rehearsed(cell_with(kRight + up + to_the_left("move", R"(, "blend_m": 0.02)") + down));
  EXPECT_THAT(said, Not(ReportsAnywhere(Code::kCollision)));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
}

/// Up beside a block and over it, 6 mm above: a blend of 60 mm cuts the corner into the block.
TEST(Move, ABlendThatCutsTheCornerIntoSomethingIsMadeSmaller) {
  const std::string block = R"(, "block": {"shape": "box", "size_m": [0.2, 0.15, 0.3675],
      "at": {"in": "room", "position_m": [0.538, 0.105, 0.18375]}})";
  const auto over = [&](const std::string& word, const std::string& blend) {
    return rehearsed(cell_with(kRight + R"({"do": "lin", "name": "up", "to": {"by_m": [0, 0, 0.12]}, "blend_m": )" +
                                   blend + R"(}, {"do": ")" + word +
                                   R"(", "name": "over", "to": {"in": "room", "position_m": [0.466, 0.269, 0.386],
                                        "rpy_deg": [0, 180, 30]}})",
                               block));
  };
  EXPECT_THAT(over("ptp", "0.06"), ReportsAnywhere(Code::kCollision, {"block"})) << "the same corner";
  const Diagnostics said = over("move", "0.06");
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_THAT(said, Notes("/program/steps/1/blend_m", {"up"}));
  EXPECT_THAT(over("move", "0.02"), Not(Notes("/program/steps/1/blend_m"))) << "as it was asked for";
}

TEST(Move, TakesAHeldPartAround) {
  const std::string bar = R"(, "bar": {"shape": "box", "size_m": [0.04, 0.4, 0.04], "fixed": false, "mass_kg": 0.4,
      "at": {"in": "room", "position_m": [0.55, -0.1, -0.055]}})";
  const std::string take =
      R"({"do": "ptp", "to": {"in": "bar", "position_m": [0, 0, 0.15], "rpy_deg": [0, 180, 0]}},
         {"do": "lin", "to": {"in": "bar", "position_m": [0, 0, 0.01]}},
         {"do": "grip", "part": "bar", "part_mass_kg": 0.4}, {"do": "lin", "to": {"by_m": [0, 0, 0.25]}}, )";
  const auto over = [](const char* word) {
    return fmt::format(R"({{"do": "{}", "name": "over", "to": {{"in": "room", "position_m": [-0.1, 0.5, 0.3],
                                                             "rpy_deg": [0, 180, 0]}}}})",
                       word);
  };
  EXPECT_THAT(rehearsed(cell_with(take + over("ptp"), bar)), ReportsAnywhere(Code::kCollision));
  const Diagnostics said = rehearsed(cell_with(take + over("move"), bar));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
}

/// The post stands beside where the base has driven to and turned; a path that is planned where the base began would
/// hit it, and so does a PTP.
TEST(Move, OfAnArmOnABaseCountsWhereThatStands) {
  const auto steps_of = [](const char* word) {
    return fmt::format(R"({{"devices": {{
      "base": {{"model": "youbot_base", "at": {{"in": "world"}}}},
      "arm": {{"model": "lwr4plus", "on": "base"}}}}, "objects": {{
      "post": {{"shape": "box", "size_m": [0.05, 0.05, 1.4],
                "at": {{"in": "world", "position_m": [1.6, 1.54, 0.75]}}}}}},
      "program": {{"do": "sequence", "steps": [
        {{"do": "lin", "arm": "base", "to": {{"in": "world", "position_m": [2, 1, 0], "rpy_deg": [0, 0, 90]}}}},
        {{"do": "ptp", "arm": "arm", "to": {{"joints_deg": [0, -30, 0, 90, 0, -60, 0]}}}},
        {{"do": "{}", "arm": "arm", "name": "turn", "to": {{"joints_deg": [90, -30, 0, 90, 0, -60, 0]}}}}]}}}})",
                       word);
  };
  EXPECT_THAT(rehearsed(steps_of("ptp")), Reports(Code::kCollision, "/program/steps/2", {"post"}));
  const Diagnostics said = rehearsed(steps_of("move"));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
}

TEST(Move, SaysThatItsGoalCollidesAndWithWhat) {
  EXPECT_THAT(rehearsed(cell_with(R"({"do": "move", "name": "into", "to": {"in": "post", "position_m": [0, 0, -0.2],
                                     "rpy_deg": [0, 180, 0]}})")),
              Reports(Code::kCollision, "/program/steps/0/to", {"post", "mm"}));
}

TEST(Move, SaysWhatIsInTheWayWhereThereIsNoPath) {
  // A wall through the axis of the first joint, with a hole for the foot of the arm, which its elbow does not fit
  // through; the goal is behind it.
  const std::string wall = R"(, "wall": {"parts": [
      {"shape": "box", "size_m": [0.02, 2, 3], "position_m": [0, 1.2, 1.45]},
      {"shape": "box", "size_m": [0.02, 2, 3], "position_m": [0, -1.2, 1.45]},
      {"shape": "box", "size_m": [0.02, 0.4, 2.4], "position_m": [0, 0, 1.8]}],
      "at": {"in": "room", "position_m": [0, 0, 0]}})";
  const Diagnostics said = rehearsed(cell_with(
      R"({"do": "move", "name": "behind", "effort": 0.1, "to": {"joints_deg": [165, -30, 0, 90, 0, -60, 0]}})", wall));
  EXPECT_THAT(said, Reports(Code::kPlanningFailed, "/program/steps/0/to", {"wall"}));
}

TEST(Move, BadParametersAreReportedAllAtOnce) {
  const Diagnostics said = rehearsed(cell_with(
      R"({"do": "move", "to": "home", "clearance_m": 0, "seed": -1, "effort": 0, "velocity_m_s": -1, "solution": "free",
          "weave": {"amplitude_m": 0.01, "frequency_Hz": 1}})"));
  for (const char* key : {"clearance_m", "seed", "effort", "velocity_m_s"})
    EXPECT_THAT(said, Reports(Code::kOutOfRange, std::string("/program/steps/0/") + key));
  EXPECT_THAT(said, Reports(Code::kUnknownKey, "/program/steps/0/solution"));
  EXPECT_TRUE(said.has_errors());
}

TEST(Move, IsACommandOfATransaction) {
  const Diagnostics said = rehearsed(cell_with(kRight + R"({"do": "transaction", "name": "around", "commands": {"go":
      {"do": "move", "start": true, "to": {"joints_deg": [90, -30, 0, 90, 0, -60, 0]}}}})"));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
}

// -- Beside machines that move
// ---------------------------------------------------------------------------------------------------

/// Two arms that face each other, each turned to its right; between them there is room for one. @param branches  of
/// each arm, in the order of the file
std::string two_arms(const std::string& left, const std::string& right) {
  return fmt::format(R"({{"devices": {{
      "left": {{"model": "lwr4plus", "at": {{"in": "world"}}}},
      "right": {{"model": "lwr4plus", "at": {{"in": "world", "position_m": [1.25, 0, 0], "rpy_deg": [0, 0, 180]}}}}}},
      "program": {{"do": "sequence", "steps": [
        {{"do": "ptp", "arm": "left", "to": {{"joints_deg": [-60, -50, 0, 70, 0, -60, 0]}}}},
        {{"do": "ptp", "arm": "right", "to": {{"joints_deg": [-60, -50, 0, 70, 0, -60, 0]}}}},
        {{"do": "parallel", "branches": [{{"do": "sequence", "steps": [{}]}},
                                         {{"do": "sequence", "steps": [{}]}}]}}]}}}})",
                     left, right);
}
/// A motion with the first joint to an angle, deg.
std::string turn(const std::string& word, const std::string& arm, double angle, const std::string& name) {
  return fmt::format(
      R"({{"do": "{}", "arm": "{}", "name": "{}", "to": {{"joints_deg": [{:g}, -50, 0, 70, 0, -60, 0]}}}})", word, arm,
      name, angle);
}
const std::string kWait = R"({"do": "wait", "seconds": 0.1}, )";

TEST(MoveBeside, GoesAroundAnArmThatCrossesItsPath) {
  const std::string crossing = turn("ptp", "right", 60, "right crosses");
  EXPECT_THAT(rehearsed(two_arms(turn("ptp", "left", 60, "left crosses"), crossing)),
              ReportsAnywhere(Code::kCollision, {"left crosses", "right crosses"}));
  const Diagnostics first = rehearsed(two_arms(turn("move", "left", 60, "left crosses"), crossing));
  EXPECT_FALSE(first.has_errors()) << first.to_string();
  EXPECT_THAT(first, Not(ReportsAnywhere(Code::kCollision)));
  // Both look for their ways: the second gives way.
  const Diagnostics both =
      rehearsed(two_arms(turn("move", "left", 60, "left crosses"), turn("move", "right", 60, "right crosses")));
  EXPECT_FALSE(both.has_errors()) << both.to_string();
}

/// Its own path is free: it is the other that is not at its place any more.
TEST(MoveBeside, WhatLeavesItsGoalInTimeIsNotInTheWay) {
  const std::string text =
      two_arms(turn("ptp", "left", 0, "left comes") + ", " + turn("ptp", "left", 60, "left leaves"),
               turn("ptp", "right", -160, "right makes room") + ", " + turn("move", "right", 0, "right comes"));
  const Diagnostics said = rehearsed(text);
  EXPECT_FALSE(said.has_errors()) << said.to_string();
}

TEST(MoveBeside, KeepsClearOfAllThatIsSweptAtTimesThatAreNotKnown) {
  const auto noted = [](const Diagnostics& said) {
    return std::ranges::any_of(said.list(), [](const Diagnostic& one) {
      return one.code == Code::kCollision || one.pointer.ends_with("/steps/1/to");
    });
  };
  const std::string crossing = turn("ptp", "right", 60, "right crosses");
  EXPECT_TRUE(noted(rehearsed(two_arms(kWait + turn("ptp", "left", 60, "left crosses"), crossing))));
  const Diagnostics around = rehearsed(two_arms(kWait + turn("move", "left", 60, "left crosses"), crossing));
  EXPECT_FALSE(around.has_errors()) << around.to_string();
  EXPECT_FALSE(noted(around)) << around.to_string();
  // No path does: the branches may wait for each other.
  const std::string comes_and_leaves =
      turn("ptp", "right", 0, "right comes") + ", " + turn("ptp", "right", -60, "right leaves");
  const std::string later = R"({"do": "wait", "seconds": 5}, )";
  const Diagnostics said = rehearsed(two_arms(later + turn("move", "left", 0, "left comes"), comes_and_leaves));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_THAT(said, Notes("/program/steps/2/branches/0/steps/1/to", {"right", "left"}));
}

/// The other arm comes to its goal, and leaves it again: no path keeps clear of that, so it begins when it has left.
TEST(MoveBeside, WaitsForWhatPassesByWhereNoPathKeepsClearOfIt) {
  const std::string text =
      two_arms(turn("move", "left", 0, "left comes"),
               turn("ptp", "right", 0, "right comes") + ", " + turn("ptp", "right", -100, "right leaves"));
  const Diagnostics said = rehearsed(text);
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_THAT(said, Not(ReportsAnywhere(Code::kCollision)));
  EXPECT_THAT(said, Notes("/program/steps/2/branches/0/steps/0"));
  const RunReport report = test::run(parsed(text));
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
}

TEST(MoveBeside, SaysWhatBlocksItsGoalAndWhen) {
  const Diagnostics said =
      rehearsed(two_arms(turn("move", "left", 0, "left comes"), turn("ptp", "right", 0, "right comes")));
  EXPECT_THAT(said, Reports(Code::kCollision, "/program/steps/2/branches/0/steps/0/to",
                            {"left/", "right/", "right comes", " s after"}));
}

// -- As a command of a transaction, beside others of it
// ------------------------------------------------------------------------------------------------

/// The two arms again: both turn in one net.
std::string in_one_net(const std::string& commands, const std::string& on = "") {
  const std::string begin = R"({"joints_deg": [-60, -50, 0, 70, 0, -60, 0]})";
  return fmt::format(R"({{"devices": {{
      "left": {{"model": "lwr4plus", "at": {{"in": "world"}}}},
      "right": {{"model": "lwr4plus", "at": {{"in": "world", "position_m": [1.25, 0, 0], "rpy_deg": [0, 0, 180]}}}}}},
      "program": {{"do": "sequence", "steps": [
        {{"do": "ptp", "arm": "left", "to": {0}}}, {{"do": "ptp", "arm": "right", "to": {0}}},
        {{"do": "transaction", "name": "cross", "commands": {{{1}}}, "on": [{2}]}}]}}}})",
                     begin, commands, on);
}
std::string turning(const std::string& name, const std::string& word, const std::string& arm, double angle,
                    bool starts = true) {
  return fmt::format(R"("{}": {{"do": "{}", "arm": "{}", "to": {{"joints_deg": [{:g}, -50, 0, 70, 0, -60, 0]}}{}}})",
                     name, word, arm, angle, starts ? R"(, "start": true)" : "");
}
const std::string kAfterAMoment = R"("moment": {"do": "wait", "seconds": 0.1, "start": true}, )";
const std::string kStartsThen = R"({"entered": {"completed": "moment"}, "start": "right"})";

TEST(MoveInATransaction, GoesAroundWhatAnotherCommandMoves) {
  const std::string crossing = turning("right", "ptp", "right", 60);
  EXPECT_THAT(rehearsed(in_one_net(turning("left", "ptp", "left", 60) + ", " + crossing)),
              ReportsAnywhere(Code::kCollision, {"left", "right"}));
  const std::string text = in_one_net(turning("left", "move", "left", 60) + ", " + crossing);
  const Diagnostics said = rehearsed(text);
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_THAT(said, Not(ReportsAnywhere(Code::kCollision)));
  const RunReport report = test::run(parsed(text));
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
}

TEST(MoveInATransaction, KeepsClearOfAllThatACommandMaySweepThatAnEventStarts) {
  const std::string moment = ", " + kAfterAMoment + turning("right", "ptp", "right", 60, false);
  const auto meetings = [](const Diagnostics& said) {
    return std::ranges::count(said.list(), Code::kCollision, &Diagnostic::code);
  };
  EXPECT_GT(meetings(rehearsed(in_one_net(turning("left", "ptp", "left", 60) + moment, kStartsThen))), 0);
  const Diagnostics said = rehearsed(in_one_net(turning("left", "move", "left", 60) + moment, kStartsThen));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_EQ(meetings(said), 0) << said.to_string();
}

TEST(MoveInATransaction, SaysWhatComesToItsGoalAtATimeThatIsNotKnown) {
  const Diagnostics said = rehearsed(
      in_one_net(turning("left", "move", "left", 0) + ", " + kAfterAMoment + turning("right", "ptp", "right", 0, false),
                 kStartsThen));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_THAT(said, Notes("/program/steps/2/commands/left/to", {"no path keeps clear", "'right' moves"}));
  const Diagnostics certain =
      rehearsed(in_one_net(turning("left", "move", "left", 0) + ", " + turning("right", "ptp", "right", 0)));
  EXPECT_THAT(certain, Reports(Code::kCollision, "/program/steps/2/commands/left/to", {"'right' moves", " s after"}));
}

/// What begins when it has completed is never in its way.
TEST(MoveInATransaction, WhatStartsWhenItHasCompletedIsNotBesideIt) {
  const Diagnostics said = rehearsed(in_one_net(
      turning("left", "move", "left", 0) + ", " + turning("back", "ptp", "left", -60, false) + ", " +
          turning("right", "ptp", "right", 0, false),
      R"({"entered": {"completed": "left"}, "start": "back"}, {"entered": {"completed": "back"}, "start": "right"})"));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_THAT(said, Not(Notes("/program/steps/2/commands/left/to")));
}

TEST(MoveInATransaction, GoesAroundWhatAnotherBranchMoves) {
  const std::string cross =
      R"({"do": "transaction", "name": "cross", "commands": {)" + turning("left", "move", "left", 60) + "}}";
  const Diagnostics said = rehearsed(two_arms(cross, turn("ptp", "right", 60, "right crosses")));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_THAT(said, Not(ReportsAnywhere(Code::kCollision)));
}

// -- On a base that another branch drives
// -------------------------------------------------------------------------------------------------------

/// The base drives past a post while its arm turns from one side to the other.
std::string driving(const std::string& arm_steps, bool known = true, const std::string& more = "") {
  return fmt::format(R"({{"devices": {{
      "base": {{"model": "youbot_base", "at": {{"in": "world"}}}},
      "arm": {{"model": "lwr4plus", "on": "base"}}}}, "objects": {{
      "post": {{"shape": "box", "size_m": [0.05, 0.05, 1.4],
                "at": {{"in": "world", "position_m": [0.9, 0.4, 0.75]}}}}}},
      "program": {{"do": "sequence", "steps": [
        {{"do": "ptp", "arm": "arm", "to": {{"joints_deg": [90, -30, 0, 90, 0, -60, 0]}}}},
        {{"do": "parallel", "branches": [
          {{"do": "sequence", "steps": [{}
            {{"do": "lin", "name": "drive", "arm": "base", "to": {{"in": "world", "position_m": [2, 0, 0]}}}}]}},
          {{"do": "sequence", "steps": [{}]}}]}}{}]}}}})",
                     known ? "" : R"({"do": "wait", "seconds": 0.2},)", arm_steps, more);
}
std::string turn_over(const std::string& word, const std::string& more = "") {
  return R"({"do": ")" + word + R"(", "arm": "arm", "name": "turn", "speed": 0.3,
             "to": {"joints_deg": [-90, -30, 0, 90, 0, -60, 0]})" +
         more + "}";
}

TEST(MoveOnADrivenBase, GoesAroundWhatTheBaseDrivesItPast) {
  EXPECT_THAT(rehearsed(driving(turn_over("ptp"))), ReportsAnywhere(Code::kCollision, {"post", "drive"}));
  const std::string text = driving(turn_over("move"));
  const Diagnostics said = rehearsed(text);
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_THAT(said, Not(ReportsAnywhere(Code::kCollision)));
  // The run finds the same path, wherever the base is when the motion begins.
  const RunReport report = test::run(parsed(text));
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  const std::string later = driving(
      R"({"do": "ptp", "arm": "arm", "name": "a little", "to": {"joints_deg": [91, -30, 0, 90, 0, -60, 0]}}, )" +
      turn_over("move"));
  EXPECT_EQ(test::run(parsed(later)).verdict, Verdict::kPassed);
}

TEST(MoveOnADrivenBase, SaysWhatIsInTheWayWhereItIsNotKnownWhenTheBaseDrives) {
  const Diagnostics said = rehearsed(driving(turn_over("move", R"(, "effort": 0.05)"), false));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_THAT(said, Notes("/program/steps/1/branches/1/steps/0/to", {"post", "'drive' moves, it is not known when"}));
}

/// Where that is when the arm gets there nobody can say; on the base it can.
TEST(GoalsMeanwhile, OnWhatMovesIsAnError) {
  const auto to = [](const std::string& in) {
    return R"({"do": "ptp", "arm": "arm", "name": "reach", "to": {"in": ")" + in +
           R"(", "position_m": [0.3, -0.4, 0.85], "rpy_deg": [0, 180, 0]}})";
  };
  const std::string pointer = "/program/steps/1/branches/1/steps/0/to";
  const auto drive_a_little = [](std::string text) { return text.replace(text.find("[2, 0, 0]"), 9, "[0.1, 0, 0]"); };
  EXPECT_THAT(rehearsed(drive_a_little(driving(to("world")))), Reports(Code::kUnknownPose, pointer, {"base", "drive"}));
  const Diagnostics riding = rehearsed(drive_a_little(driving(to("base/flange"))));
  EXPECT_FALSE(riding.has_errors()) << riding.to_string();
  const Diagnostics said = rehearsed(drive_a_little(driving(to("world"), false)));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
  EXPECT_EQ(std::ranges::count(said.list(), Code::kUnknownPose, &Diagnostic::code), 1) << said.to_string();
}

TEST(PtpSolution, FreeIsTheNearestWhosePathIsFree) {
  const auto go = [](const std::string& more) {
    return kRight + R"({"do": "ptp", "name": "go", "to": {"in": "room", "position_m": [0.0, 0.55, 0.4],
                       "rpy_deg": [0, 180, 0]})" +
           more + "}";
  };
  EXPECT_THAT(rehearsed(cell_with(go(""))), Reports(Code::kCollision, "/program/steps/1", {"post"}));
  const Diagnostics said = rehearsed(cell_with(go(R"(, "solution": "free")")));
  EXPECT_FALSE(said.has_errors()) << said.to_string();
}

}  // namespace
}  // namespace takt::cell::move_test
