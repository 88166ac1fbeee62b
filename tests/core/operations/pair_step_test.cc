// Two arms as one in programs: "lin" and "circ" with a follower (rows P5, S1, L6, P2, D3).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/activity/pair_fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using Json = nlohmann::ordered_json;

class PairStepTest : public test::PairProgramTest {};

TEST_F(PairStepTest, P5_MotionsInOneFileAreOneAndKeepBothTogether) {
  const Eigen::Vector3d from = tool();
  ASSERT_EQ(run(sequence(both("up", "0, 0, 0.1") + "," + both("last", "0, 0.1, 0") + "," + kArc)), Progress::kDone)
      << diagnostics.to_string();
  EXPECT_THAT(rehearsed.list(), IsEmpty());
  EXPECT_LT(apart, 1e-9);
  EXPECT_EQ(standing, 0);
  EXPECT_LT((tool() - from - Eigen::Vector3d(0, 0.16, 0.1)).norm(), 1e-8);
  EXPECT_THAT(begun(), ElementsAre("up", "last", "round"));
  EXPECT_EQ(backends["left"]->last_written_cycle, backends["right"]->last_written_cycle);
  expect_good_end();
}

TEST_F(PairStepTest, P5_TheyGoOnOverWhateverDecidesWhatComesNext) {
  const std::string between[] = {kLog, R"({"do": "branch", "cases": [{"when": "$1 < 2", "steps": []}]},)",
                                 R"({"do": "repeat", "times": 2, "steps": [{"do": "log", "text": "x"}]},)"};
  for (const std::string& one : between) {
    SCOPED_TRACE(one);
    log.clear();
    const Eigen::Vector3d from = tool();
    ASSERT_EQ(run(sequence(both("up", "0, 0, 0.05") + "," + one + both("last", "0, 0.05, 0") + "," + one +
                           both("back", "0, -0.05, -0.05", ""))),
              Progress::kDone)
        << diagnostics.to_string();
    EXPECT_LT(apart, 1e-9);
    EXPECT_EQ(standing, 0);
    EXPECT_THAT(log, Not(Contains(HasSubstr("no blend"))));
    EXPECT_LT((tool() - from).norm(), 1e-8);
    EXPECT_THAT(begun(), ElementsAre("up", "last", "back"));
  }
  expect_good_end();
}

TEST_F(PairStepTest, ASequenceOfPairMotionsNeverLosesItsGrasp) {
  const Eigen::Isometry3d before = X_LF();
  const std::string round = both("up", "0, 0, 0.05") + "," + both("aside", "0, 0.05, 0", "") + "," + kLog +
                            both("down", "0, 0, -0.05") + "," + kLog + both("back", "0, -0.05, 0", "");
  ASSERT_EQ(run(R"({"do": "repeat", "times": 10, "steps": [)" + round + "]}"), Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT((X_LF().matrix() - before.matrix()).cwiseAbs().maxCoeff(), 1e-9);
  expect_good_end();
}

TEST_F(PairStepTest, WhatIsNoMotionOfTheSameTwoWaitsForTheEnd) {
  const std::string one = R"({"do": "lin", "arm": "right", "name": "alone", "to": {"by_m": [0, 0, 0.02]})";
  const auto at_its_begin = [&](const std::string& steps, const char* name) {
    double speed_then = -1.0;
    EXPECT_EQ(run(sequence(steps),
                  [&](int, program::ProgramRunner& runner) {
                    if (speed_then < 0.0 && runner.current() == name) speed_then = speed("left") + speed("right");
                  }),
              Progress::kDone)
        << diagnostics.to_string();
    return speed_then;
  };
  EXPECT_EQ(at_its_begin(both("up", "0, 0, 0.05") + "," + one + "}", "alone"), 0.0);
  EXPECT_THAT(pointers(rehearsed), ElementsAre("/program/steps/0")) << "a note says that it stops";
  EXPECT_EQ(at_its_begin(one + kBlend + "}," + both("up", "0, 0, 0.05", ""), "up"), 0.0);
  EXPECT_THAT(pointers(rehearsed), ElementsAre("/program/steps/0"));
  const std::string swapped =
      R"({"do": "lin", "arm": "right", "follower": "left", "name": "swapped", "to": {"by_m": [0, 0, -0.05]}})";
  EXPECT_EQ(at_its_begin(both("up", "0, 0, 0.05") + "," + kLog + swapped, "swapped"), 0.0);
  EXPECT_LT(apart, 1e-9);
  expect_good_end();
}

TEST_F(PairStepTest, EveryProgramLatencyGivesARightProgram) {
  for (const std::int64_t cycles_of_latency : {0, 1, 10, 50}) {
    SCOPED_TRACE(cycles_of_latency);
    latency = cycles_of_latency;
    const Eigen::Vector3d from = tool();
    ASSERT_EQ(run(sequence(both("up", "0, 0, 0.08") + "," + kLog + both("last", "0, 0.08, 0") + "," + kLog +
                           both("back", "0, -0.08, -0.08", ""))),
              Progress::kDone)
        << diagnostics.to_string();
    EXPECT_LT(apart, 1e-9);
    EXPECT_LT((tool() - from).norm(), 1e-8);
  }
  expect_good_end();
}

// Rows L6, P2: wherever they are cancelled, both come to rest on the path, together.
TEST_F(PairStepTest, L6_ACancelAtAnyCycleStopsBothOnThePath) {
  const program::Program tree = good(sequence(both("up", "0, 0, 0.06") + "," + kLog + both("aside", "0, 0.06, 0") +
                                              "," + both("back", "0, -0.06, -0.06", "")));
  cancel_at_every(70, tree);
  expect_good_end();
}

TEST_F(PairStepTest, P2_APauseStopsBothAndTheyGoOn) {
  const program::Program tree = good(sequence(both("up", "0, 0, 0.08") + "," + kLog + both("last", "0, 0.08, 0", "")));
  const Eigen::Vector3d from = tool();
  double paused = -1.0;
  ASSERT_EQ(run(tree,
                [&](int cycle, program::ProgramRunner&) {
                  device::Channel& rate = *cell.channels.at("left.speed");
                  if (cycle == 250) (void)rate.write(0.0);
                  if (cycle == 700) paused = speed("left") + speed("right");
                  if (cycle == 700) (void)rate.write(0.5);
                  if (cycle == 1'200) (void)rate.write(1.0);
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(paused, 0.0);
  EXPECT_LT(apart, 1e-9);
  EXPECT_LT((tool() - from - Eigen::Vector3d(0, 0.08, 0.08)).norm(), 1e-8);
  expect_good_end();
}

TEST_F(PairStepTest, AnInternalForceIsALimitThatFailsTheStep) {
  const auto squeeze_later = [this](int cycle, program::ProgramRunner&) { squeeze(cycle > 300 ? 30.0 : 5.0); };
  const Eigen::Vector3d from = tool();
  ASSERT_EQ(run(sequence(both("up", "0, 0, 0.15", R"(, "velocity_m_s": 0.1)" + unless(20))), squeeze_later),
            Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/steps/0/abort_if")) << diagnostics.to_string();
  EXPECT_THAT(diagnostics, Reports(Code::kAbortCondition, "/program/steps/0/abort_if", {"abort_if"}));
  EXPECT_LT(apart, 1e-9) << "on the path";
  EXPECT_GT(tool().z(), from.z() + 0.005);
  EXPECT_LT(tool().z(), from.z() + 0.1);
  expect_good_end();
  EXPECT_EQ(run(sequence(both("down", "0, 0, -0.01", unless(40))), squeeze_later), Progress::kDone)
      << "30 N are not 40: " << diagnostics.to_string();
}

TEST_F(PairStepTest, AnInternalForceIsHandledByATry) {
  const Eigen::Vector3d from = tool();
  const std::string carry = both("up", "0, 0, 0.15", R"(, "velocity_m_s": 0.1, "blend_m": 0.02)" + unless(20)) + "," +
                            kLog + both("last", "0, 0.1, 0", unless(20));
  ASSERT_EQ(run(R"({"do": "try", "steps": [)" + carry + R"(], "on_error": {"as": "why", "steps": [
                {"do": "log", "text": "$'handled: ' + why"},)" +
                    both("down", "0, 0, -0.02", "") + "]}}",
                [this](int cycle, program::ProgramRunner&) { squeeze(cycle > 300 && cycle < 900 ? 30.0 : 0.0); }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_THAT(log, Contains(testing::AllOf(HasSubstr("log handled: "), takt::test::Names("abort_if"))));
  EXPECT_LT(apart, 1e-9);
  EXPECT_LT(tool().z(), from.z() + 0.1);
  expect_good_end();
}

/// What is left of a motion is driven by the net of the one that goes on with it: the limit still counts, and no more
/// once it is over.
TEST_F(PairStepTest, ALimitHoldsUntilItsMotionIsOverAndNoLonger) {
  const std::string first = both("up", "0, 0, 0.12", R"(, "velocity_m_s": 0.1, "blend_m": 0.02)" + unless(20));
  const program::Program joined = good(sequence(first + "," + both("aside", "0, 0.1, 0", "")));
  const program::Program apart_in_file = good(sequence(first + "," + kLog + both("aside", "0, 0.1, 0", "")));
  for (const program::Program* tree : {&joined, &apart_in_file}) {
    SCOPED_TRACE(tree == &joined ? "one net" : "taken over");
    for (const bool in_time : {true, false}) {
      SCOPED_TRACE(in_time);
      squeeze(0.0);
      log.clear();
      const Eigen::Vector3d from = tool();
      const Progress progress = run(*tree, [&](int, program::ProgramRunner&) {
        const Eigen::Vector3d way = tool() - from;
        squeeze((in_time ? way.z() > 0.09 : way.y() > 0.03) ? 30.0 : 0.0);
      });
      EXPECT_EQ(progress, in_time ? Progress::kFailed : Progress::kDone) << diagnostics.to_string();
      EXPECT_LT(apart, 1e-9);
      const Eigen::Vector3d back = from - tool();
      squeeze(0.0);
      ASSERT_EQ(run(both("back", fmt::format("{}, {}, {}", back.x(), back.y(), back.z()).c_str(), "")), Progress::kDone)
          << diagnostics.to_string();
    }
  }
  expect_good_end();
}

TEST_F(PairStepTest, ASilentSensorIsNoForceAndStopsThem) {
  ASSERT_EQ(run(sequence(both("up", "0, 0, 0.15", R"(, "velocity_m_s": 0.1)" + unless(20))),
                [this](int cycle, program::ProgramRunner&) { wrists["right"]->silent = cycle > 300; }),
            Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kSensorSilent, "/program/steps/0/abort_if"));
  EXPECT_LT(apart, 1e-9);
  expect_good_end();
}

TEST_F(PairStepTest, GuardedByAForceTheyTouch) {
  const auto touches = [this](int, program::ProgramRunner&) { squeeze(tool().z() > 0.0 ? 30.0 : 0.0); };
  const std::string guarded = R"(, "velocity_m_s": 0.05, "until": )" + squeezed(20);
  ASSERT_EQ(run(sequence(both("up", "0, 0, 0.1", guarded) + R"(, {"do": "record_contact", "arm": "left", "as": "c"})"),
                touches),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_TRUE(variables.contacts.contains("c"));
  EXPECT_LT(apart, 1e-9);
  squeeze(0.0);
  EXPECT_EQ(run(sequence(both("down", "0, 0, -0.02", guarded))), Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program/steps/0/until"));
  EXPECT_EQ(run(sequence(both("up", "0, 0, 0.02", guarded + R"(, "on_end": "continue")"))), Progress::kDone);
  expect_good_end();
}

// Row D3: a pair motion that was left open is begun again, from where both are.
TEST_F(PairStepTest, D3_ASnapshotKnowsTheMotionThatWasLeftOpen) {
  const program::Program tree = good(sequence(
      R"({"do": "lin", "arm": "left", "follower": "right", "name": "up", "blend_m": 0.02,
          "to": {"in": "world", "position_m": [0.56, 0, 1.05]}},)" +
      std::string(kLog) +
      R"({"do": "lin", "arm": "left", "follower": "right", "name": "aside",
          "to": {"in": "world", "position_m": [0.56, 0.08, 1.05]}})"));
  const double half = 0.5 * (tool().z() + 1.05);
  const std::string text = snapshot_when(
      tree, [&](const program::ProgramRunner& runner) { return runner.current() == "up" && tool().z() >= half; });
  ASSERT_THAT(text, HasSubstr("\"open\""));
  ASSERT_THAT(text, HasSubstr("\"follower\""));
  ASSERT_EQ(go_on(tree, text), Progress::kDone) << diagnostics.to_string();
  EXPECT_LT(apart, 1e-9);
  EXPECT_LT((tool() - Eigen::Vector3d(0.56, 0.08, 1.05)).norm(), 1e-6);
  expect_good_end();
}

/// Brings both into a mode of impedance, then the steps.
std::string on_springs(const std::string& steps) {
  const std::string change = R"({"do": "control_mode", "mode": "cartesian_impedance", "arm": )";
  return R"({"do": "sequence", "steps": [)" + change + R"("left"}, )" + change + R"("right"}, )" + steps + "]}";
}
std::string pair_springs(double stiffness) {
  return fmt::format(R"(, "compliance": {{"mode": "cartesian_impedance", "stiffness_N_m": {}}})", stiffness);
}

TEST_F(PairStepTest, P5_BothGiveWayAlikeAndBlendWithEqualSprings) {
  for (const bool alike : {true, false}) {
    SCOPED_TRACE(alike);
    for (const auto& [name, backend] : backends) backend->given.clear();
    log.clear();
    const std::string own = pair_springs(alike ? 800 : 400);
    EXPECT_EQ(run(on_springs(both("up", "0, 0, 0.08", kBlend + pair_springs(800)) + ", " +
                             both("last", "0.04, 0, 0", kBlend + own) + ", " + both("back", "0, 0, -0.02", own))),
              Progress::kDone)
        << diagnostics.to_string();
    EXPECT_EQ(standing == 0, alike) << "what has other springs begins at rest";
    EXPECT_LT(apart, 1e-9);
    for (const auto& [name, backend] : backends) {
      EXPECT_EQ(backend->given.back().stiffness.head(3), Eigen::Vector3d::Constant(alike ? 800 : 400)) << name;
      const auto had = [&](double k) {
        return std::ranges::any_of(backend->given, [&](const auto& one) { return one.stiffness[2] == k; });
      };
      EXPECT_TRUE(had(800)) << name;
    }
    const std::string back = R"({"do": "control_mode", "mode": "position", "arm": )";
    EXPECT_EQ(run(sequence(back + R"("left"}, )" + back + R"("right"})")), Progress::kDone);
  }
  expect_good_end();
}

TEST_F(PairStepTest, InATransactionBothGiveWayToo) {
  const std::string command = both("m", "0, 0, 0.02", R"(, "start": true)" + pair_springs(600));
  EXPECT_EQ(run(on_springs(R"({"do": "transaction", "commands": {"m": )" +
                           std::string(command).replace(command.find(R"("name": "m", )"), 13, "") + "}}")),
            Progress::kDone)
      << diagnostics.to_string();
  for (const auto& [name, backend] : backends) EXPECT_EQ(backend->given.back().stiffness[0], 600) << name;
  EXPECT_LT(apart, 1e-9);
  expect_good_end();
}

TEST_F(PairStepTest, TheArmThatIsNotInTheModeIsNamed) {
  const Diagnostics one = wrong(sequence(R"({"do": "control_mode", "mode": "cartesian_impedance", "arm": "left"}, )" +
                                         both("up", "0, 0, 0.02", pair_springs(800))));
  EXPECT_THAT(pointers(one), ElementsAre("/program/steps/1/compliance")) << one.to_string();
  EXPECT_THAT(one, Reports(Code::kNotPossibleNow, "/program/steps/1/compliance", {"right", "cartesian_impedance"}));
  const Diagnostics too_stiff = wrong(on_springs(both("up", "0, 0, 0.02", pair_springs(6000))));
  for (const char* one_of_them : {"left", "right"})
    EXPECT_THAT(too_stiff,
                Reports(Code::kOutOfRange, "/program/steps/2/compliance/stiffness_N_m/0", {"6000", one_of_them}));
}

TEST_F(PairStepTest, WhatTheFollowerCannotDoIsSeenBeforeAnythingMoves) {
  const Diagnostics far = wrong(sequence(both("aside", "-0.1, 0.55, 0", "")));
  EXPECT_THAT(pointers(far), Contains("/program/steps/0/follower")) << far.to_string();
  const Diagnostics alone = wrong(sequence(R"({"do": "lin", "arm": "left", "to": {"by_m": [-0.1, 0.55, 0]}})"));
  EXPECT_FALSE(alone.has_errors()) << "the leader could: " << alone.to_string();
}

}  // namespace
}  // namespace takt::operations
