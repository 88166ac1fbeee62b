// Motions that go on with one another although the program decides between them what comes next: what the arm does,
// what makes it stop, what is known of failures, and that nothing is left behind wherever it is interrupted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"

namespace takt::program {
namespace {

using takt::test::Reports;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

class GoingOnTest : public test::ActivityTest {
 protected:
  /// A LIN to a place over the block; `more` are keys with a comma before them.
  static std::string lin(const char* name, const char* place, const std::string& more = kBlend) {
    return fmt::format(R"({{"do": "lin", "name": "{}", "to": {{"in": "block", "position_m": [{}]}}{}}})", name, place,
                       more);
  }
  static constexpr const char* kBlend = R"(, "blend_m": 0.04)";
  static constexpr const char* kApproach = R"({"do": "ptp", "to": {"in": "block", "position_m": [0, -0.1, 0.2]}},)";
  static constexpr const char* kThere = "0, 0.1, 0.2";
  static constexpr const char* kAside = "-0.15, 0.1, 0.2";

  /// Two motions with something between them. @return cycles in which the arm stood there
  int standing_between(const std::string& between) {
    EXPECT_EQ(run(sequence(std::string(kApproach) + R"({"do": "wait", "seconds": 0.01})")),
              operations::Progress::kDone);
    fake.backend->sent.clear();
    log.clear();
    EXPECT_EQ(run(sequence(lin("there", kThere) + "," + between + lin("aside", kAside, ""))),
              operations::Progress::kDone)
        << diagnostics.to_string();
    EXPECT_LE(fake.worst_limit_share(), 1.0);
    EXPECT_LT((tool_in_block() - Eigen::Vector3d(-0.15, 0.1, 0.2)).norm(), 1e-6);
    EXPECT_THAT(begun(), testing::IsSupersetOf({"there", "aside"}));
    return standing_cycles();
  }
  Eigen::Vector3d tool_in_block() const {
    const Eigen::Isometry3d X_WO = *fake.cell.frames.pose("block");
    return X_WO.inverse() * fake.tool_in_world(fake.q()).translation();
  }
};

TEST_F(GoingOnTest, BlendsOverWhateverDecidesWhatComesNext) {
  EXPECT_EQ(standing_between(R"({"do": "log", "text": "on the way"},)"), 0);
  EXPECT_EQ(standing_between(R"({"do": "branch", "cases": [{"when": "$1 < 2", "steps": []}]},)"), 0);
  EXPECT_EQ(standing_between(R"({"do": "sequence", "variables": {"n": 3}, "steps": [
      {"do": "let", "values": {"n": "$n + 1"}}]},)"),
            0);
  EXPECT_EQ(standing_between(R"({"do": "repeat", "times": 3, "steps": [{"do": "log", "text": "x"}]},)"), 0);
  EXPECT_EQ(standing_between(R"({"do": "try", "steps": [{"do": "log", "text": "x"}], "on_error": {"steps": []}},)"), 0);
}

TEST_F(GoingOnTest, WhatLooksAtTheCellOrDrivesItWaitsForTheEnd) {
  EXPECT_GT(standing_between(R"({"do": "wait", "seconds": 0.01},)"), 5);
  EXPECT_GT(standing_between(R"j({"do": "log", "text": "$text(position('arm'))"},)j"), 0);
  EXPECT_THAT(log, Contains(HasSubstr("log (")));
  EXPECT_GT(standing_between(R"({"do": "branch", "cases": [{"when": "$time() > 0[s]", "steps": []}]},)"), 0);
  EXPECT_GT(standing_between(R"({"do": "wait", "until": "$1 < 2"},)"), 0);
  EXPECT_GT(standing_between(R"({"do": "parallel", "branches": [{"do": "log", "text": "x"}]},)"), 0);
  EXPECT_GT(standing_between(R"({"do": "branch", "cases": [
      {"when": {"sensor": "wrist", "above_N": 1000}, "steps": []}]},)"),
            0);
}

TEST_F(GoingOnTest, AskedForAPlaceOfTheArmItTellsTheGoal) {
  ASSERT_EQ(run(sequence(std::string(kApproach) + lin("there", kThere) + R"j(, {"do": "sequence", "variables":
      {"off": {"unit": "m"}}, "steps": [
        {"do": "let", "values": {"off": "$distance(position('arm'), pose('block') * at(0[m], 0.1[m], 0.2[m]))"}},
        {"do": "log", "text": "$text(off < 0.001[mm])"}]})j")),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_THAT(log, Contains("program: log true"));
}

TEST_F(GoingOnTest, LoopsOfMotionsNeverStopBetweenRounds) {
  ASSERT_EQ(run(sequence(std::string(kApproach) + R"({"do": "for_each", "as": "at", "in": [
      {"in": "block", "position_m": [0, 0.1, 0.2]}, {"in": "block", "position_m": [-0.15, 0.1, 0.2]},
      {"in": "block", "position_m": [-0.15, -0.1, 0.2]}, {"in": "block", "position_m": [0, -0.1, 0.2]}],
      "steps": [{"do": "lin", "name": "on", "to": {"in": "$at", "position_m": [0, 0, 0]}, "blend_m": 0.05}]})")),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_THAT(begun(), ElementsAre("ptp", "on", "on", "on", "on"));
  EXPECT_EQ(steps_done, 5);
  EXPECT_THAT(log, Not(Contains(HasSubstr("no blend"))));
  EXPECT_LT((tool_in_block() - Eigen::Vector3d(0, -0.1, 0.2)).norm(), 1e-6);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(GoingOnTest, EveryProgramLatencyGivesARightProgram) {
  for (const std::int64_t cycles_of_latency : {0, 1, 5, 20, 50}) {
    SCOPED_TRACE(cycles_of_latency);
    latency = cycles_of_latency;
    (void)standing_between(R"({"do": "log", "text": "on the way"},)");
  }
}

TEST_F(GoingOnTest, AStepsNameIsTheOneOfTheMotionThatIsBeingDone) {
  std::vector<std::string> seen;
  ASSERT_EQ(run(sequence(std::string(kApproach) + R"({"do": "wait", "seconds": 0.01})")), operations::Progress::kDone);
  const Program program =
      good(sequence(lin("there", kThere) + R"(, {"do": "log", "text": "x"},)" + lin("aside", kAside, "")));
  double turned_at = 0.0;
  ASSERT_EQ(run(program,
                [&](int, ProgramRunner& runner) {
                  if (!seen.empty() && seen.back() == runner.current()) return;
                  if (runner.current() == "aside") turned_at = tool_in_block().x();
                  if (!runner.current().empty()) seen.push_back(runner.current());
                }),
            operations::Progress::kDone);
  EXPECT_THAT(seen, ElementsAre("there", "aside"));
  EXPECT_LT(turned_at, -0.002) << "in the middle of the blend";
  EXPECT_GT(turned_at, -0.04);
}

TEST_F(GoingOnTest, AGuardedMotionFeelsOnlyItsOwnWay) {
  const std::string program = sequence(std::string(kApproach) + lin("over", "0, 0, 0.09", R"(, "blend_m": 0.01)") + R"(,
      {"do": "log", "text": "x"},
      {"do": "lin", "name": "down", "to": {"by_m": [0, 0, -0.1], "in": "block"}, "velocity_m_s": 0.02,
       "until": {"sensor": "wrist", "above_N": 8}}, {"do": "record_contact", "as": "top"})");
  const auto push_on_the_way = [this](int, ProgramRunner&) {
    const bool on_the_way = tool_in_block().y() < -0.045;
    fake.extra.force = on_the_way ? Eigen::Vector3d(0, 0, 60) : Eigen::Vector3d::Zero();
  };
  ASSERT_EQ(run(good(program), push_on_the_way), operations::Progress::kDone) << diagnostics.to_string();
  EXPECT_THAT(log, Not(Contains(HasSubstr("no blend"))));
  EXPECT_NEAR(variables.contacts.at("top").p_R.z(), (fake.X_WO_true * Eigen::Vector3d(0, 0, 0.03)).z(), 1e-4);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

/// By then the successor's net drives the rest of the way.
TEST_F(GoingOnTest, AFailureIsToldOnceAtTheStepWhoseNetDrives) {
  const std::string program = sequence(std::string(kApproach) + lin("there", kThere) +
                                       R"(, {"do": "log", "text": "x"},)" + lin("aside", kAside, ""));
  const auto abort_there = [this](int, ProgramRunner& runner) {
    if (runner.current() == "there" && tool_in_block().y() > 0.0) abort_all();
  };
  EXPECT_EQ(run(good(program), abort_there), operations::Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/steps/3")) << diagnostics.to_string();
  EXPECT_LT(tool_in_block().y(), 0.1);
}

TEST_F(GoingOnTest, AFailureInsideATryIsHandledThere) {
  const std::string program =
      sequence(std::string(kApproach) + R"({"do": "try", "steps": [)" + lin("there", kThere) +
               R"(], "on_error": {"as": "why", "steps": [{"do": "log", "text": "$'handled: ' + why"}]}})");
  const auto abort_there = [this](int, ProgramRunner& runner) {
    if (runner.current() == "there" && tool_in_block().y() > 0.0) abort_all();
  };
  EXPECT_EQ(run(good(program), abort_there), operations::Progress::kDone) << diagnostics.to_string();
  EXPECT_THAT(log, Contains(HasSubstr("log handled: ")));
}

TEST_F(GoingOnTest, AGoalThatCannotBeReachedStopsTheMotionBefore) {
  const std::string program =
      sequence(std::string(kApproach) + lin("there", kThere) +
               R"(, {"do": "sequence", "variables": {"far": {"unit": "m", "nominal": 0.1}}, "steps": [
      {"do": "let", "values": {"far": "$3[m]"}},
      {"do": "lin", "name": "far", "to": {"by_m": ["$far", 0, 0]}}]})");
  EXPECT_EQ(run(program), operations::Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/steps/2/steps/1/to"));
  EXPECT_TRUE(fake.core_arm().at_rest());
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

// Rows L6, P2: between motions that go on with each other as anywhere else.
TEST_F(GoingOnTest, L6_P2_CancelAtEveryTenthCycleLeavesTheArmAtRest) {
  const Program program =
      good(sequence(std::string(kApproach) + lin("there", kThere) + R"(, {"do": "log", "text": "x"},)" +
                    lin("aside", kAside) + R"(, {"do": "log", "text": "y"},)" + lin("down", "-0.15, 0, 0.1", "")));
  cancel_at_every_tenth_cycle(program);
}

TEST_F(GoingOnTest, P2_UnderAnyOverrideAndAPauseTheGoalsAreReached) {
  const Program program = good(sequence(std::string(kApproach) + lin("there", kThere) +
                                        R"(, {"do": "log", "text": "x"},)" + lin("aside", kAside, "")));
  for (const int at : {300, 600, 900, 1200, 1500, 1800}) {
    SCOPED_TRACE(at);
    fake.backend->sent.clear();
    ASSERT_EQ(run(program,
                  [this, at](int cycle, ProgramRunner&) {
                    if (cycle == at) (void)fake.speed->write(0.0);
                    if (cycle == at + 400) (void)fake.speed->write(0.6);
                    if (cycle == at + 700) (void)fake.speed->write(1.0);
                  }),
              operations::Progress::kDone)
        << diagnostics.to_string();
    EXPECT_LT((tool_in_block() - Eigen::Vector3d(-0.15, 0.1, 0.2)).norm(), 1e-6);
    EXPECT_LE(fake.worst_limit_share(), 1.0);
  }
}

// Row D3: the motion that was left open is begun again, from where the arm is, and the program goes on with it.
TEST_F(GoingOnTest, D3_ASnapshotKnowsTheMotionThatWasLeftOpen) {
  const Program program = good(sequence(std::string(kApproach) + lin("there", kThere) +
                                        R"(, {"do": "log", "text": "x"},)" + lin("aside", kAside, "")));
  for (const double y : {-0.05, 0.0, 0.04}) {
    SCOPED_TRACE(y);
    const std::string text = snapshot_when(
        program, [&](const ProgramRunner& runner) { return runner.current() == "there" && tool_in_block().y() >= y; });
    ASSERT_THAT(text, HasSubstr("\"open\""));
    double farthest = -1.0;
    const auto look = [&](int, ProgramRunner&) { farthest = std::max(farthest, tool_in_block().y()); };
    ASSERT_EQ(go_on(program, text, look), operations::Progress::kDone) << diagnostics.to_string();
    EXPECT_GT(farthest, 0.07) << "the way of the first motion";
    EXPECT_LT((tool_in_block() - Eigen::Vector3d(-0.15, 0.1, 0.2)).norm(), 1e-6);
  }
}

/// The frame of the loop's place has moved on already when the snapshot is taken.
TEST_F(GoingOnTest, D3_AnOpenMotionKeepsItsOwnPlaceOfALoop) {
  const Program program = good(sequence(std::string(kApproach) + R"({"do": "for_each", "as": "at", "in": [
      {"in": "block", "position_m": [0, 0.1, 0.2]}, {"in": "block", "position_m": [-0.15, 0.1, 0.2]}],
      "steps": [{"do": "lin", "name": "on", "to": {"in": "$at", "position_m": [0, 0, 0]}, "blend_m": 0.04}]})"));
  const std::string text = snapshot_when(
      program, [&](const ProgramRunner& runner) { return runner.current() == "on" && tool_in_block().y() >= -0.05; });
  double farthest = -1.0;
  const auto look = [&](int, ProgramRunner&) {
    if (tool_in_block().x() > -0.01) farthest = std::max(farthest, tool_in_block().y());
  };
  ASSERT_EQ(go_on(program, text, look), operations::Progress::kDone) << diagnostics.to_string();
  EXPECT_GT(farthest, 0.07) << "straight ahead to the first place, and only then aside";
  EXPECT_LT((tool_in_block() - Eigen::Vector3d(-0.15, 0.1, 0.2)).norm(), 1e-6);
}

TEST_F(GoingOnTest, D3_AMotionThatIsTheWholeProgramIsBegunAgainOnce) {
  ASSERT_EQ(run(sequence(std::string(kApproach) + R"({"do": "wait", "seconds": 0.01})")), operations::Progress::kDone);
  const Program program = good(R"({"do": "lin", "name": "up", "to": {"by_m": [0, 0, 0.1]}, "blend_m": 0.02})");
  const std::string text = snapshot_when(program, [&](const ProgramRunner&) { return tool_in_block().z() >= 0.22; });
  const double begin = tool_in_block().z();
  ASSERT_EQ(go_on(program, text), operations::Progress::kDone) << diagnostics.to_string();
  EXPECT_NEAR(tool_in_block().z(), begin + 0.1, 1e-6);
}

TEST_F(GoingOnTest, AFailureOfAMotionBeforeATryIsNotItsOwn) {
  const std::string program =
      sequence(std::string(kApproach) + lin("there", kThere) +
               R"(, {"do": "try", "retry": 2, "steps": [{"do": "wait", "seconds": 0.01}], "on_error": {"steps": []}})");
  const auto abort_there = [this](int, ProgramRunner& runner) {
    if (runner.current() == "there" && tool_in_block().y() > 0.0) abort_all();
  };
  EXPECT_EQ(run(good(program), abort_there), operations::Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/steps/1")) << diagnostics.to_string();
}

TEST_F(GoingOnTest, WhatCleansUpIsNotCancelledWithABranch) {
  const std::string program =
      sequence(std::string(kApproach) + R"({"do": "parallel", "end": "first", "branches": [
      {"do": "wait", "seconds": 0.8},
      {"do": "try", "steps": [{"do": "wait", "seconds": 0.1}], "finally": [)" +
               lin("there", kThere) + R"(, {"do": "log", "text": "x"},)" + lin("aside", kAside, "") + "]}]}");
  EXPECT_EQ(run(program), operations::Progress::kDone) << diagnostics.to_string();
  EXPECT_LT((tool_in_block() - Eigen::Vector3d(-0.15, 0.1, 0.2)).norm(), 1e-6);
}

TEST_F(GoingOnTest, TheRehearsalTellsWhereNothingGoesOn) {
  const auto notes = [&](const std::string& steps) { return pointers(rehearsed(sequence(kApproach + steps))); };
  const std::string there = lin("there", kThere), aside = lin("aside", kAside, "");
  EXPECT_THAT(notes(there + R"(, {"do": "log", "text": "x"},)" + aside), IsEmpty());
  EXPECT_THAT(notes(there + R"(, {"do": "wait", "seconds": 1},)" + aside), ElementsAre("/program/steps/1"));
  EXPECT_THAT(notes(there), ElementsAre("/program/steps/1"));
  EXPECT_THAT(notes(R"({"do": "parallel", "branches": [)" + there + "]}," + aside),
              ElementsAre("/program/steps/1/branches/0"));
}

}  // namespace
}  // namespace takt::program
