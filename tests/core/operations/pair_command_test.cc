// Two arms as one in transactions: "lin", "circ" and "motions" with a follower (rows P5, L6, N3, C7).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/activity/pair_fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;
using testing::Contains;
using testing::ElementsAre;
using testing::UnorderedElementsAre;

class PairCommandTest : public test::PairProgramTest {
 protected:
  static std::string tree(const std::string& commands, const std::string& more = "") {
    return R"({"do": "transaction", "name": "t", "commands": {)" + commands + "}" + more + "}";
  }
  /// A command of both arms; `more` are keys with a comma before them.
  static std::string lin(const char* name, const char* by, const std::string& more = "") {
    return fmt::format(R"("{}": {{"do": "lin", "arm": "left", "follower": "right", "to": {{"by_m": [{}]}}{}}})", name,
                       by, more);
  }
  static constexpr const char* kStart = R"(, "start": true)";
  /// Up, then aside, blended.
  static constexpr const char* kCorner = R"("corner": {"do": "motions", "start": true, "steps": [
      {"do": "lin", "arm": "left", "follower": "right", "to": {"by_m": [0, 0, 0.1]}, "blend_m": 0.03},
      {"do": "lin", "arm": "left", "follower": "right", "to": {"by_m": [0, 0.1, 0]}}]})";

  /// In every cycle from the first set point of the last run on both move, or both stand.
  void expect_same_clock(std::size_t from) const {
    const auto &left = backends.at("left")->sent, &right = backends.at("right")->sent;
    ASSERT_EQ(left.size(), right.size());
    for (std::size_t k = from; k < left.size(); ++k) {
      EXPECT_EQ(left[k].cycle, right[k].cycle);
      EXPECT_EQ(left[k].dq.norm() < 1e-9, right[k].dq.norm() < 1e-9) << "cycle " << left[k].cycle;
    }
  }
  std::string told(const char* what) { return variables.monitors["t"][what]; }
};

TEST_F(PairCommandTest, P5_BlendedMotionsAreOneAndKeepBothTogether) {
  const Eigen::Vector3d from = tool();
  double stood = 0.0;
  ASSERT_EQ(run(tree(kCorner, R"(, "on": [{"entered": {"action": "corner", "via_passed": 0}, "tell": "corner"},
                {"entered": {"action": "corner", "at_path": 0.5}, "tell": "half"},
                {"entered": {"action": "corner", "is": "error"}, "tell": "error"},
                {"entered": {"actuator": "right", "is": "invalid_set_point"}, "tell": "nothing sent"}],
                "capture": {"z": {"value": {"progress": "corner"}, "when": {"action": "corner", "via_passed": 0}}})"),
                [&](int, program::ProgramRunner&) {
                  const Eigen::Vector3d way = tool() - from;
                  if (way.z() > 0.02 && way.y() < 0.08) stood = std::max(stood, speed("left") < 1e-4 ? 1.0 : 0.0);
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT(apart, 1e-9);
  EXPECT_EQ(stood, 0.0) << "it does not stop in the corner";
  EXPECT_LT((tool() - from - Eigen::Vector3d(0, 0.1, 0.1)).norm(), 1e-8);
  EXPECT_EQ(told("corner"), "1");
  EXPECT_EQ(told("half"), "1");
  EXPECT_EQ(told("error"), "") << "never";
  EXPECT_EQ(told("nothing sent"), "");
  EXPECT_NEAR(std::stod(told("z")), 0.5, 0.05) << "the middle of the blend of two ways of one length";
  expect_same_clock(0);
  expect_good_end();
}

// On one clock: both begin to brake in one cycle, and stand in one cycle.
TEST_F(PairCommandTest, AHandlerThatCancelsStopsBothOnThePath) {
  for (const double share : {0.1, 0.3, 0.48, 0.55, 0.8}) {
    SCOPED_TRACE(share);
    const Eigen::Vector3d from = tool();
    const std::size_t before = backends.at("left")->sent.size();
    ASSERT_EQ(run(tree(kCorner, fmt::format(R"(, "on": [{{"entered": {{"action": "corner", "at_path": {}}},
                  "cancel": "corner"}}], "capture": {{"end": {{"value": {{"progress": "corner"}}}}}})",
                                            share)),
                  [&](int, program::ProgramRunner&) {
                    const Eigen::Vector3d way = tool() - from;
                    EXPECT_LT(std::abs(way.x()), 1e-8) << "in the plane of the path";
                    if (way.z() < 0.07) {
                      EXPECT_LT(std::abs(way.y()), 1e-8) << "before the blend";
                    }
                  }),
              Progress::kDone)
        << diagnostics.to_string();
    EXPECT_LT(apart, 1e-9);
    EXPECT_GT((tool() - from).norm(), share * 0.1);
    EXPECT_LT((tool() - from - Eigen::Vector3d(0, 0.1, 0.1)).norm(), 0.2 * (1.0 - share));
    expect_same_clock(before);
    const Eigen::Vector3d back = from - tool();
    ASSERT_EQ(run(tree(lin("back", fmt::format("{}, {}, {}", back.x(), back.y(), back.z()).c_str(), kStart))),
              Progress::kDone)
        << "they are free again: " << diagnostics.to_string();
    EXPECT_LT(apart, 1e-9);
  }
  expect_good_end();
}

TEST_F(PairCommandTest, L6_ACancelAtAnyCycleStopsBothOnThePath) {
  const program::Program both_ways = good(tree(std::string(kCorner) + "," + lin("down", "0, -0.1, -0.1"),
                                               R"(, "on": [{"entered": {"completed": "corner"}, "start": "down"}])"));
  cancel_at_every(130, both_ways);
  expect_good_end();
}

TEST_F(PairCommandTest, TheGraspIsTakenWhereACommandBegins) {
  const Eigen::Vector3d from = tool();
  const Eigen::Isometry3d before = X_LF();
  // Each arm goes its own way, then both go one: by plan from where those ways end.
  const std::string alone = R"("l": {"do": "lin", "start": true, "arm": "left", "to": {"by_m": [0, 0, 0.02]}},
      "r": {"do": "lin", "start": true, "arm": "right", "to": {"by_m": [0, 0, 0.05]}},)";
  const std::string arc =
      R"("round": {"do": "circ", "arm": "left", "follower": "right", "via": {"by_m": [0.03, 0.03, 0]},
      "to": {"by_m": [0, 0.06, 0]}})";
  Eigen::Isometry3d taken = before;
  double slipped = 0.0;
  ASSERT_EQ(run(R"({"do": "sequence", "steps": [)" +
                    tree(alone + lin("up", "0, 0, 0.1") + "," + arc,
                         R"(, "on": [{"entered": {"all": [{"completed": "l"}, {"completed": "r"}]}, "start": "up"},
                                     {"entered": {"completed": "up"}, "start": "round"},
                                     {"entered": {"started": "up"}, "tell": "as one"}])") +
                    "," + both("last", "0, 0, -0.02", "") + "]}",
                [&](int, program::ProgramRunner&) {
                  // Both stand to each other as they will: 50 and 20 mm up.
                  const double up_right = flange("right").translation().z() - tool().z();
                  if (std::abs(up_right - 0.03) > 1e-7) return;
                  const bool stand = speed("left") + speed("right") < 1e-12;
                  if (taken.isApprox(before) && stand) taken = X_LF();
                  if (taken.isApprox(before)) return;
                  slipped = std::max(slipped, (X_LF().matrix() - taken.matrix()).cwiseAbs().maxCoeff());
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(told("as one"), "1");
  EXPECT_FALSE(taken.isApprox(before, 1e-3));
  EXPECT_LT((X_LF().matrix() - taken.matrix()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(slipped, 1e-9);
  EXPECT_LT((tool() - from - Eigen::Vector3d(0, 0.06, 0.1)).norm(), 1e-6);
  expect_good_end();
}

TEST_F(PairCommandTest, GuardedByAForceTheyTouch) {
  const std::string guarded = R"(, "start": true, "velocity_m_s": 0.05, "until": )" + squeezed(20);
  const Eigen::Vector3d from = tool();
  ASSERT_EQ(
      run(sequence(tree(lin("up", "0, 0, 0.1", guarded)) + R"(, {"do": "record_contact", "arm": "left", "as": "c"})"),
          [&](int, program::ProgramRunner&) { squeeze(tool().z() > from.z() + 0.05 ? 30.0 : 0.0); }),
      Progress::kDone)
      << diagnostics.to_string();
  EXPECT_TRUE(variables.contacts.contains("c"));
  EXPECT_LT(apart, 1e-9);
  EXPECT_NEAR(tool().z(), from.z() + 0.05, 0.01);
  squeeze(0.0);
  EXPECT_EQ(run(tree(lin("down", "0, 0, -0.02", guarded))), Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/commands/down/until"));
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program/commands/down/until"));
  EXPECT_EQ(run(tree(lin("up", "0, 0, 0.02", guarded + R"(, "on_end": "continue")"))), Progress::kDone);
  expect_good_end();
}

TEST_F(PairCommandTest, AnInternalForceIsALimitThatFailsTheTransactionAtItsPlace) {
  const Eigen::Vector3d from = tool();
  const std::string first = both("up", "0, 0, 0.1", R"(, "velocity_m_s": 0.1, "blend_m": 0.02)" + unless(20));
  const std::string motions =
      R"("carry": {"do": "motions", "start": true, "steps": [)" + first + "," + both("aside", "0, 0.1, 0", "") + "]}";
  ASSERT_EQ(
      run(tree(motions), [&](int, program::ProgramRunner&) { squeeze(tool().z() > from.z() + 0.03 ? 30.0 : 5.0); }),
      Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/commands/carry/steps/0/abort_if"))
      << diagnostics.to_string();
  EXPECT_THAT(diagnostics, Reports(Code::kAbortCondition, "/program/commands/carry/steps/0/abort_if", {"abort_if"}));
  EXPECT_LT(apart, 1e-9) << "on the path";
  EXPECT_LT(tool().z(), from.z() + 0.06);
  // The limit of a motion is none of the next one's.
  squeeze(0.0);
  EXPECT_EQ(
      run(tree(motions), [&](int, program::ProgramRunner&) { squeeze(tool().y() > from.y() + 0.03 ? 30.0 : 5.0); }),
      Progress::kDone)
      << diagnostics.to_string();
  expect_good_end();
}

/// As a state of the transaction it may do anything; here it cancels them in order.
TEST_F(PairCommandTest, AnInternalForceIsAStateOfTheTransaction) {
  const Eigen::Vector3d from = tool();
  const std::string on = R"(, "on": [{"entered": )" + squeezed(20) + R"(, "cancel": "up", "tell": "squeezed"}])";
  ASSERT_EQ(run(tree(lin("up", "0, 0, 0.15", R"(, "start": true, "velocity_m_s": 0.1)"), on),
                [&](int, program::ProgramRunner&) { squeeze(tool().z() > from.z() + 0.05 ? 30.0 : 5.0); }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(told("squeezed"), "1");
  EXPECT_LT(apart, 1e-9);
  EXPECT_GT(tool().z(), from.z() + 0.05);
  EXPECT_LT(tool().z(), from.z() + 0.07);
  expect_good_end();
}

TEST_F(PairCommandTest, N3_ASilentSensorStopsThemAndIsTold) {
  ASSERT_EQ(run(tree(lin("up", "0, 0, 0.15", R"(, "start": true, "velocity_m_s": 0.1, "until": )" + squeezed(20))),
                [this](int cycle, program::ProgramRunner&) { wrists["right"]->silent = cycle > 300; }),
            Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kSensorSilent, "/program/commands/up/until"));
  EXPECT_LT(apart, 1e-9);
  expect_good_end();
}

TEST_F(PairCommandTest, C7_NothingElseMovesOneOfThemAtTheSameTime) {
  const std::string pair = lin("pair", "0, 0, 0.05", kStart);
  for (const char* one : {"left", "right"}) {
    const Diagnostics both_want = wrong(
        tree(pair + R"(, "alone": {"do": "ptp", "start": true, "to": "home", "arm": ")" + std::string(one) + "\"}"));
    EXPECT_THAT(pointers(both_want), Contains("/program/commands/alone"));
    EXPECT_THAT(both_want, Reports(Code::kResourceConflict, "/program/commands/alone", {"C7", one, "/t/pair"}));
  }
  const std::string swapped = R"("swapped": {"do": "lin", "start": true, "arm": "right", "follower": "left",
      "to": {"by_m": [0, 0, 0.05]}})";
  EXPECT_THAT(wrong(tree(pair + "," + swapped)),
              Reports(Code::kResourceConflict, "/program/commands/swapped", {"left", "C7"}));
  // Whoever comes later is told in its cycle, and both stop.
  ASSERT_EQ(run(tree(pair + R"(, "alone": {"do": "hold", "arm": "right", "seconds": 0.1})",
                     R"(, "on": [{"entered": {"action": "pair", "at_path": 0.5}, "start": "alone"}])")),
            Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kStopped, "/program", {"alone", "pair"}));
  expect_good_end();
}

TEST_F(PairCommandTest, WhereTheyBeginIsKnownBeforeOrRefused) {
  const std::string one = R"("l": {"do": "lin", "start": true, "arm": "left", "to": {"by_m": [0, 0, 0.02]}},
      "r": {"do": "lin", "start": true, "arm": "right", "to": {"by_m": [0, 0, 0.02]},
            "abort_if": {"sensor": "right wrist", "above_N": 5}},)";
  const Diagnostics found = wrong(tree(one + lin("up", "0, 0, 0.05"),
                                       R"(, "on": [{"entered": {"all": [{"completed": "l"}, {"completed": "r"}]},
                                                 "start": "up"}])"));
  EXPECT_THAT(pointers(found), ElementsAre("/program/commands/up"));
  EXPECT_THAT(found, Reports(Code::kUnknownPosition, "/program/commands/up", {"right", "up", "r"}));
  const Diagnostics chance =
      wrong(tree(one + lin("up", "0, 0, 0.05"), R"(, "on": [{"entered": {"input": "x"}, "start": "up"}])"));
  EXPECT_TRUE(chance.has_errors());
  const Diagnostics both_unknown = wrong(tree(one + lin("up", "0, 0, 0.05"),
                                              R"(, "on": [{"entered": {"sensor": "left wrist", "above_N": 5},
                                                        "start": "up"}])"));
  // A note: the transaction may end before the sensor starts it.
  EXPECT_THAT(pointers(both_unknown),
              UnorderedElementsAre("/program/on/0", "/program/commands/up", "/program/commands/up"))
      << both_unknown.to_string();
}

TEST_F(PairCommandTest, WhatTheFollowerCannotDoIsSeenBeforeAnythingMoves) {
  EXPECT_THAT(pointers(wrong(tree(lin("aside", "-0.1, 0.55, 0", kStart)))),
              Contains("/program/commands/aside/follower"));
  const std::string motions = R"("m": {"do": "motions", "start": true, "steps": [)" +
                              both("up", "0, 0, 0.02", R"(, "blend_m": 0.01)") + "," + both("far", "0, 0, 3", "") +
                              "]}";
  const Diagnostics far = wrong(tree(motions));
  EXPECT_THAT(pointers(far), Contains("/program/commands/m/steps/0/to")) << far.to_string();
  EXPECT_THAT(far, Reports(Code::kOutOfRange, "/program/commands/m/steps/0/to", {"far"}));
}

/// The rehearsal takes both to the end of the transaction, and counts its time.
TEST_F(PairCommandTest, TheRehearsalKnowsWhereBothEnd) {
  const Eigen::Vector3d from = tool();
  ASSERT_EQ(run(sequence(tree(kCorner) + "," + both("down", "0, -0.1, -0.1", "") + "," +
                         R"({"do": "lin", "arm": "right", "to": {"by_m": [0, 0, 0.02]}})")),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT((tool() - from).norm(), 1e-8);
  const auto parsed = program::Program::parse(nlohmann::ordered_json::parse(tree(kCorner)), "/program", cell);
  ASSERT_TRUE(parsed);
  EXPECT_GT(parsed->rehearse(cell, &core.environment()).duration, 0.3);
}

}  // namespace
}  // namespace takt::operations
