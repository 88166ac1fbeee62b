// Expectations about a part of the program, each both ways.
#include "cell/judge/expectations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/judge/step_window.h"
#include "cell/run/session.h"
#include "tests/cell/described.h"
#include "tests/support/reports.h"

namespace takt::cell::part_expectations_test {
namespace {

using takt::test::Names;
using takt::test::Reports;
using test::models;
using test::parsed;

/// Touches a block twice in a loop, with a pause of 0.3 s between.
std::string scenario(const std::string& expectations) {
  return R"({"devices": {
      "arm": {"model": "lwr4plus", "start_deg": [0, -30, 0, 90, 0, -60, 0]},
      "wrist": {"model": "ft_gamma", "on": "arm"}, "probe": {"model": "probe_ball", "on": "wrist"}},
    "objects": {"block": {"shape": "box", "size_m": [0.4, 0.4, 0.2], "at": {"position_m": [0.55, 0, 0.1]}}},
    "program": {"do": "sequence", "name": "main", "steps": [
      {"do": "ptp", "name": "above", "to": {"in": "block", "position_m": [0, 0, 0.12], "rpy_deg": [180, 0, 0]}},
      {"do": "tare"},
      {"do": "repeat", "name": "measure", "times": 2, "steps": [
        {"do": "lin", "name": "touch", "to": {"by_m": [0, 0, -0.04]}, "velocity_m_s": 0.02,
         "until": {"sensor": "wrist", "above_N": 5}},
        {"do": "lin", "name": "away", "to": {"by_m": [0, 0, 0.02]}},
        {"do": "wait", "name": "pause", "seconds": 0.3}]}]},
    "expectations": [)" +
         expectations + "]}";
}

Result<std::unique_ptr<Session>> open(const std::string& expectations) {
  return Session::create(parsed(scenario(expectations)), models());
}

/// All of them in one run: what held, in their order, and what was measured.
struct Judged {
  std::vector<bool> held;
  std::vector<ExpectationResult> results;
};
Judged judged(const std::string& expectations) {
  auto session = open(expectations);
  if (!session) {
    ADD_FAILURE() << session.error().to_string();
    return {};
  }
  Judged judged;
  judged.results = (*session)->run({}).expectations;
  for (const ExpectationResult& result : judged.results) judged.held.push_back(result.passed);
  return judged;
}

TEST(PartExpectations, AValueCountsWhileItsStepRuns) {
  const Judged all = judged(R"json(
      {"kind": "value", "value": "$force('wrist')", "during": "touch", "at_most": 60},
      {"kind": "value", "value": "$force('wrist')", "during": "touch", "at_most": 4},
      {"kind": "value", "value": "$force('wrist')", "during": "pause", "at_most": 1},
      {"kind": "value", "value": "$force('wrist')", "during": "measure", "at_most": 4},
      {"kind": "value", "value": "$force('wrist')", "at_most": 4})json");
  EXPECT_EQ(all.held, (std::vector<bool>{true, false, true, false, false})) << all.results.at(1).measured;
  EXPECT_GT(all.results.at(0).value, 5.0);
  EXPECT_THAT(all.results.at(0).measured, Names("N", "60")) << "with its unit";
}

/// The tool begins 20 mm above the block, touches it twice and ends 20 mm above the touch.
TEST(PartExpectations, APoseCountsInEachCycleOfItsStep) {
  const Judged all = judged(R"json(
      {"kind": "tool_pose", "in": "block", "position_m": [0, 0, 0.12], "position_within_m": 0.012},
      {"kind": "tool_pose", "in": "block", "position_m": [0, 0, 0.12], "position_within_m": 0.03, "during": "measure"},
      {"kind": "tool_pose", "in": "block", "position_m": [0, 0, 0.12], "position_within_m": 0.012, "during": "pause"},
      {"kind": "tool_pose", "in": "block", "position_m": [0, 0, 0.12], "position_within_m": 0.012, "during": "measure"},
      {"kind": "object_pose", "object": "block", "position_m": [0.55, 0, 0.1], "position_within_m": 1e-4,
       "during": "touch"},
      {"kind": "object_pose", "object": "block", "position_m": [0.55, 0, 0.1], "position_within_m": 1e-4,
       "during": "measure (3)"})json");
  EXPECT_EQ(all.held, (std::vector<bool>{true, true, true, false, true, false})) << all.results.at(3).measured;
}

/// Fixed and up to 50 mm off its drawing: what stands on it is judged by where it truly is.
TEST(PartExpectations, APoseIsJudgedInAFrameThatIsTrulyElsewhere) {
  auto session = Session::create(parsed(R"json({"devices": {"arm": {"model": "lwr4plus"}},
    "frames": {"corner": {"in": "bench", "position_m": [0.1, 0.1, 0.05]}},
    "objects": {
      "bench": {"shape": "box", "size_m": [0.4, 0.4, 0.1], "at": {"position_m": [2, 0, 0.05]},
                "vary": {"position_m": [0.05, 0.05, 0], "rpy_deg": [0, 0, 20]}},
      "part": {"shape": "box", "size_m": [0.04, 0.04, 0.04], "at": {"in": "corner", "position_m": [0, 0, 0.02]},
               "fixed": false, "mass_kg": 0.2}},
    "program": {"do": "wait", "name": "pause", "seconds": 0.2},
    "expectations": [
      {"kind": "object_pose", "object": "part", "in": "corner", "position_m": [0, 0, 0.02], "position_within_m": 1e-4,
       "angle_within_deg": 0.1},
      {"kind": "object_pose", "object": "part", "in": "corner", "position_m": [0, 0, 0.02], "position_within_m": 1e-4,
       "during": "pause"},
      {"kind": "object_pose", "object": "part", "position_m": [2.1, 0.1, 0.12], "position_within_m": 1e-4}]})json"),
                                 models());
  ASSERT_TRUE(session.has_value()) << session.error().to_string();
  const auto results = (*session)->run({}).expectations;
  ASSERT_EQ(results.size(), 3u);
  EXPECT_TRUE(results[0].passed) << results[0].measured;
  EXPECT_TRUE(results[1].passed) << results[1].measured;
  EXPECT_FALSE(results[2].passed) << results[2].measured;
}

TEST(PartExpectations, AContactForceCountsWhileItsStepRuns) {
  const Judged all = judged(R"json(
      {"kind": "contact_force", "between": ["probe", "block"], "below_N": 60, "at_least_N": 5},
      {"kind": "contact_force", "between": ["probe", "block"], "below_N": 60, "at_least_N": 5, "during": "touch"},
      {"kind": "contact_force", "between": ["probe", "block"], "below_N": 4, "during": "touch"},
      {"kind": "contact_force", "between": ["probe", "block"], "below_N": 0.1, "during": "pause"},
      {"kind": "contact_force", "between": ["probe", "block"], "below_N": 4, "during": "measure"},
      {"kind": "contact_force", "between": ["probe", "block"], "below_N": 60, "at_least_N": 5,
       "during": "measure (2) / touch"},
      {"kind": "contact_force", "between": ["probe", "block"], "below_N": 60, "during": "measure (3) / touch"})json");
  EXPECT_EQ(all.held, (std::vector<bool>{true, true, false, true, false, true, false}));
  EXPECT_LE(all.results.at(1).value, all.results.at(0).value);
  EXPECT_THAT(all.results.at(1).measured, Names("touch", "60"));
}

TEST(PartExpectations, AShareOfTheTimeAndTheMeanMayBeBounded) {
  const Judged all = judged(R"json(
      {"kind": "value", "value": "$force('wrist')", "during": "measure", "at_most": 1, "share": 0.5},
      {"kind": "value", "value": "$force('wrist')", "during": "measure", "at_most": 1, "share": 0.999},
      {"kind": "value", "value": "$force('wrist')", "during": "measure", "mean_at_most": 2},
      {"kind": "value", "value": "$force('wrist')", "during": "measure", "mean_at_least": 2})json");
  EXPECT_EQ(all.held, (std::vector<bool>{true, false, true, false}));
}

TEST(PartExpectations, EventsAreCounted) {
  const Judged all = judged(R"json(
      {"kind": "event", "source": "arm", "event": "touch", "times": 2},
      {"kind": "event", "source": "arm", "event": "touch", "times": 1},
      {"kind": "event", "source": "arm", "event": "touch", "during": "away"},
      {"kind": "event", "source": "program", "event": "begin", "text": "pause", "at_least": 2, "at_most": 2},
      {"kind": "event", "source": "program", "event": "retry", "at_most": 0},
      {"kind": "event", "source": "program", "event": "begin", "text": "touch", "to_s": 0.5})json");
  EXPECT_EQ(all.held, (std::vector<bool>{true, false, false, true, true, false}));
}

TEST(PartExpectations, EventsHaveWindowsInTheTimeOfTheirStep) {
  // The pause takes 0.3 s, twice; the whole loop takes longer than that.
  const Judged all = judged(R"json(
      {"kind": "event", "source": "program", "event": "end", "during": "pause", "from_s": 0.29, "to_s": 0.31,
       "times": 2},
      {"kind": "event", "source": "program", "event": "end", "during": "pause", "to_s": 0.2},
      {"kind": "event", "source": "program", "event": "begin", "during": "pause", "to_s": 0.001, "times": 2},
      {"kind": "event", "source": "program", "event": "end", "text": "pause", "during": "measure", "from_s": 0.31,
       "times": 2},
      {"kind": "event", "source": "program", "event": "begin", "text": "touch", "during": "measure (2)", "to_s": 0.1,
       "times": 1})json");
  EXPECT_EQ(all.held, (std::vector<bool>{true, false, true, true, true})) << all.results.at(0).measured;
  EXPECT_THAT(all.results.at(1).measured, Names("0", "2", "step"));
}

TEST(PartExpectations, AnOrderHasItsWindows) {
  const Judged all = judged(R"json(
      {"kind": "order", "events": [{"event": "begin", "text": "touch"}, {"source": "contact", "event": "contact"},
                                   {"event": "begin", "text": "pause"}]},
      {"kind": "order", "events": [{"event": "begin", "text": "pause"}, {"event": "begin", "text": "above"}]},
      {"kind": "order", "events": [{"event": "begin", "text": "pause"},
                                   {"event": "end", "text": "pause", "within_s": 0.31}]},
      {"kind": "order", "events": [{"event": "begin", "text": "pause"},
                                   {"event": "end", "text": "pause", "within_s": 0.2}]})json");
  EXPECT_EQ(all.held, (std::vector<bool>{true, false, true, false}));
  EXPECT_THAT(all.results.at(1).measured, Names("1", "2", "above")) << "what did not come";
}

TEST(PartExpectations, ContactsAreThoseThatAreMeant) {
  const Judged all = judged(R"json({"kind": "contacts", "only": [["block", "probe"]]}, {"kind": "contacts", "only": []},
             {"kind": "contacts", "only": [["pr*", "b*k"]]}, {"kind": "contacts", "only": [["block", "b*"]]})json");
  EXPECT_EQ(all.held, (std::vector<bool>{true, false, true, false}));
  EXPECT_THAT(all.results.at(1).measured, Names("block", "probe", "N"));
}

TEST(PartExpectations, MistakesAreFoundBeforeTheRun) {
  const auto session = open(R"json(
      {"kind": "value", "value": "$force('wirst')", "at_most": 1},
      {"kind": "value", "value": "$force('wrist') > 1[N]", "at_most": 1},
      {"kind": "value", "value": "$force('wrist')", "during": "tuch", "at_most": 1},
      {"kind": "value", "value": "$force('wrist')"},
      {"kind": "value", "value": "$force('wrist')", "at_least": 2, "at_most": 1},
      {"kind": "order", "events": [{"event": "begin", "during": "nowhere"}, {"event": "end"}]},
      {"kind": "contacts", "only": [["probe", "blok"]]})json");
  ASSERT_FALSE(session);
  const std::string at = "/expectations/";
  EXPECT_THAT(session.error(), Reports(Code::kTypeMismatch, at + "0/value", {"wirst", "wrist"}));
  EXPECT_THAT(session.error(), Reports(Code::kTypeMismatch, at + "1/value"));
  EXPECT_THAT(session.error(), Reports(Code::kUnknownName, at + "2/during", {"tuch", "touch"}));
  EXPECT_THAT(session.error(), Reports(Code::kMissing, at + "3", {"at_most"}));
  EXPECT_THAT(session.error(), Reports(Code::kConflict, at + "4/at_least", {"2", "1"}));
  EXPECT_THAT(session.error(), Reports(Code::kUnknownName, at + "5/events/0/during", {"nowhere"}));
  EXPECT_THAT(session.error(), Reports(Code::kUnknownName, at + "6/only/0/1", {"blok", "block"}));
}

TEST(StepWindow, APathGoesThroughItsNodes) {
  EXPECT_TRUE(goes_through("a / b (2) / c", "a"));
  EXPECT_TRUE(goes_through("a / b (2) / c", "b"));
  EXPECT_TRUE(goes_through("a / b (2) / c", "c"));
  EXPECT_TRUE(goes_through("a / b (2) / c", "b (2)"));
  EXPECT_TRUE(goes_through("a / b (2) / c", "a / c"));
  EXPECT_TRUE(goes_through("a / b (2) / c", "b (2) / c"));
  EXPECT_FALSE(goes_through("a / b (2) / c", "b (1) / c"));
  EXPECT_FALSE(goes_through("a / b (2) / c", "c / a"));
  EXPECT_FALSE(goes_through("a / b (2) / c", "a / c / d"));
  EXPECT_FALSE(goes_through("a / b (2) / c", "d"));
  EXPECT_FALSE(goes_through("a / bb / c", "b"));
  EXPECT_TRUE(goes_through("grip (left)", "grip (left)"));
  EXPECT_FALSE(goes_through("grip (left)", "grip")) << "that is no round";
  EXPECT_FALSE(goes_through("", "a"));
}

TEST(StepWindow, APathEndsWithTheNodeThatHasBegun) {
  EXPECT_TRUE(ends_with("a / b (2) / c", "c"));
  EXPECT_TRUE(ends_with("a / b (2) / c", "b / c"));
  EXPECT_TRUE(ends_with("a / b (2) / c", "a / c"));
  EXPECT_TRUE(ends_with("a / b (2)", "b"));
  EXPECT_FALSE(ends_with("a / b (2) / c", "b")) << "it began before";
  EXPECT_FALSE(ends_with("a / b (2) / c", "b (1) / c"));
  EXPECT_FALSE(ends_with("a / c", "b / c"));
  EXPECT_FALSE(ends_with("", "c"));
}

TEST(StepWindow, PartsThatNoStepHasAreFound) {
  const std::vector<std::string> steps{"a", "b", "grip (left)"};
  EXPECT_THAT(unknown_parts("a / b (2)", steps), testing::IsEmpty());
  EXPECT_THAT(unknown_parts("a / c (2) / b / d", steps), testing::ElementsAre("c (2)", "d"));
  EXPECT_THAT(unknown_parts("grip (left)", steps), testing::IsEmpty());
  EXPECT_THAT(unknown_parts("grip", steps), testing::ElementsAre("grip"));
}

}  // namespace
}  // namespace takt::cell::part_expectations_test
