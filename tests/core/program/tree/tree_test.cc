// The nodes of a program: what they do, what is refused, how a rehearsal sees them.
#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"

namespace takt::program {
namespace {

using takt::test::Notes;
using takt::test::Reports;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

class TreeTest : public test::ActivityTest {
 protected:
  static test::Json json(const std::string& text) { return test::Json::parse(text); }
  Result<Program> with_programs(const std::string& text, const std::string& programs) const {
    const test::Json known = json(programs);
    return Program::parse(json(text), "/program", fake.cell, &known);
  }
  /// What log steps said.
  std::vector<std::string> said() const {
    std::vector<std::string> texts;
    for (const std::string& line : log) {
      if (line.starts_with("program: log ")) texts.push_back(line.substr(13));
    }
    return texts;
  }
  std::vector<std::string> said_by(const std::string& text) {
    log.clear();
    EXPECT_EQ(run(text), operations::Progress::kDone) << diagnostics.to_string();
    return said();
  }
  Diagnostics rehearsed(const std::string& text) {
    return good(text).rehearse(fake.cell, &fake.core.environment()).diagnostics;
  }
  static std::string sequence(const std::string& steps, const std::string& variables = "{}") {
    return R"({"do": "sequence", "variables": )" + variables + R"(, "steps": [)" + steps + "]}";
  }
  static std::string say(const std::string& text) { return R"({"do": "log", "text": ")" + text + "\"}"; }
  static std::string wait(int cycles) { return R"({"do": "wait", "seconds": )" + std::to_string(0.001 * cycles) + "}"; }
  static constexpr const char* kMove = R"({"do": "ptp", "name": "move", "to": {"joints_deg": [10,0,0,-90,0,90,0]}})";
};

// -- Variables -----------------------------------------------------------------------------------------------------

TEST_F(TreeTest, VariablesAreCountedWith) {
  EXPECT_THAT(
      said_by(sequence(R"({"do": "let", "values": {"n": "$n + 1", "h": "$h * n"}},)" + say("$text(n) + ' ' + text(h)"),
                       R"({"n": 1, "h": {"unit": "m", "value": 0.1}})")),
      ElementsAre("2 0.2 m"));
}

TEST_F(TreeTest, VariablesEndWithTheirSequence) {
  EXPECT_THAT(said_by(sequence(sequence(R"({"do": "let", "values": {"n": 5, "m": 6}})", R"({"n": 2})") + "," +
                                   say("$text(n) + text(m)"),
                               R"({"n": 1, "m": 1})")),
              ElementsAre("16"));
  EXPECT_THAT(refused(sequence(sequence("", R"({"inner": 2})") + R"(, {"do": "let", "values": {"inner": 1}})")),
              ElementsAre("/program/steps/1/values/inner"));
}

TEST_F(TreeTest, VariablesStandInStepsGoalsAndConditions) {
  EXPECT_EQ(run(sequence(R"({"do": "ptp", "to": {"in": "$place", "position_m": [0, 0, "$up"]}, "speed": "$speed"},
      {"do": "lin", "to": {"by_m": [0, 0, "$-up"]}, "velocity_m_s": "$up / 2[s]",
       "until": {"sensor": "wrist", "above_N": "$limit"}, "on_end": "continue"})",
                         R"({"place": {"in": "block", "position_m": [0, 0, 0.1]}, "up": "$0.05[m]", "speed": 0.4,
                             "limit": {"unit": "N", "value": 60}})")),
            operations::Progress::kDone)
      << diagnostics.to_string();
  const Eigen::Vector3d p = fake.tool_in_world(fake.q()).translation();
  const Eigen::Vector3d wanted = fake.cell.frames.pose("block")->translation() + Eigen::Vector3d(0, 0, 0.1);
  EXPECT_LT((p - wanted).norm(), 1e-6);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(TreeTest, MotionsWithExpressionsBlendToo) {
  EXPECT_EQ(run(sequence(R"({"do": "lin", "name": "a", "to": {"by_m": [0, 0, "$d"]}, "blend_m": 0.01},
                             {"do": "lin", "name": "b", "to": {"by_m": [0, "$d", 0]}})",
                         R"({"d": 0.05})")),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(steps_done, 2);
  EXPECT_EQ(std::ranges::count(log, "program: begin b"), 1);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(TreeTest, WhatIsWrongWithVariablesIsToldAtOnce) {
  EXPECT_THAT(refused(sequence(R"({"do": "let", "values": {"m": 1, "n": "$h", "t": "$n +"}},
      {"do": "lin", "to": {"by_m": [0, 0, "$t"]}, "velocity_m_s": "$force", "spede": "$n"},
      {"do": "ptp", "to": "home", "name": "$t"},
      {"do": "log", "text": "$n"})",
                               R"({"n": 1, "h": "$1[m]", "t": "a", "force": "$3[N]", "2x": 1, "and": 2,
                                   "bad": {"type": "nubmer"}})")),
              ElementsAre("/program/variables/2x", "/program/variables/and", "/program/variables/bad",
                          "/program/steps/0/values/m", "/program/steps/0/values/n", "/program/steps/0/values/t",
                          "/program/steps/1/velocity_m_s", "/program/steps/1/spede", "/program/steps/2/name",
                          "/program/steps/3/text"));
}

TEST_F(TreeTest, AValueThatIsNotKnownStopsTheStepThatNeedsIt) {
  const std::string late =
      sequence(R"({"do": "lin", "name": "late", "to": {"by_m": [0, 0, "$h"]}})", R"({"h": {"unit": "m"}})");
  const Diagnostics before = rehearsed(late);
  EXPECT_FALSE(before.has_errors());
  EXPECT_THAT(before, Notes("/program/steps/0", {"h"}));
  EXPECT_EQ(run(late), operations::Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kNotKnownYet, "/program/steps/0", {"h"}));
  EXPECT_THAT(pointers(rehearsed(
                  sequence(R"({"do": "lin", "to": {"by_m": [0, 0, "$h"]}})", R"({"h": {"unit": "m", "nominal": 3}})"))),
              ElementsAre("/program/steps/0/to"))
      << "nominally out of reach";
}

// -- branch --------------------------------------------------------------------------------------------------------

std::string choose(const std::string& colour) {
  return R"({"do": "sequence", "variables": {"colour": ")" + colour + R"("}, "steps": [
    {"do": "branch", "cases": [
      {"when": "$colour == 'red'", "steps": [{"do": "log", "text": "stop"}]},
      {"when": "$colour == 'green'", "steps": [{"do": "log", "text": "go"}]}],
     "else": [{"do": "log", "text": "look"}]}]})";
}

TEST_F(TreeTest, ABranchTakesTheFirstWayThatHolds) {
  EXPECT_THAT(said_by(choose("red")), ElementsAre("stop"));
  EXPECT_THAT(said_by(choose("green")), ElementsAre("go"));
  EXPECT_THAT(said_by(choose("blue")), ElementsAre("look"));
}

TEST_F(TreeTest, ABranchAsksASensorInANet) {
  const std::string ask = R"({"do": "branch", "cases": [{"when": {"sensor": "wrist", "above_N": 50},
      "steps": [{"do": "log", "text": "pushed"}]}], "else": [{"do": "log", "text": "free"}]})";
  EXPECT_THAT(said_by(ask), ElementsAre("free"));
  fake.extra.force = {0, 0, 80};
  EXPECT_THAT(said_by(ask), ElementsAre("pushed"));
  fake.sensor->silent = true;
  EXPECT_EQ(run(ask), operations::Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program/cases/0/when"));
}

TEST_F(TreeTest, AllWaysAreRehearsed) {
  const auto branch = [](const std::string& when) {
    return sequence(R"({"do": "branch", "cases": [{"when": ")" + when +
                        R"(", "steps": [{"do": "lin", "to": {"by_m": [0, 0, 3]}}]}],
                        "else": [{"do": "lin", "to": {"by_m": [0, 3, 0]}}]})",
                    R"({"n": 1, "open": {"type": "boolean"}})");
  };
  EXPECT_THAT(pointers(rehearsed(branch("$open"))),
              ElementsAre("/program/steps/0/cases/0/steps/0/to", "/program/steps/0/else/0/to"));
  const Diagnostics taken = rehearsed(branch("$n == 1"));
  ASSERT_EQ(taken.list().size(), 2u);
  EXPECT_EQ(taken.list()[0].severity, Severity::kError);
  EXPECT_EQ(taken.list()[1].severity, Severity::kWarning) << "nominal values do not come here";
}

TEST_F(TreeTest, ABranchIsCheckedForForm) {
  EXPECT_THAT(refused(R"({"do": "branch", "cases": [{"when": "red", "steps": []}, {"steps": []},
                          {"when": "$1 + 1", "steps": []}, {"when": {"sensor": "writs", "above_N": 1}, "steps": []},
                          {"when": "$true"}], "esle": []})"),
              ElementsAre("/program/cases/0/when", "/program/cases/1", "/program/cases/2/when",
                          "/program/cases/3/when/sensor", "/program/cases/4", "/program/esle"));
  EXPECT_THAT(refused(R"({"do": "branch", "cases": []})"), ElementsAre("/program/cases"));
}

// -- repeat and for_each -------------------------------------------------------------------------------------------

TEST_F(TreeTest, RepeatCountsItsRounds) {
  EXPECT_THAT(said_by(R"({"do": "repeat", "times": 3, "as": "i", "steps": [{"do": "log", "text": "$text(i) "}]})"),
              ElementsAre("0", "1", "2"));
  EXPECT_THAT(said_by(sequence(R"({"do": "repeat", "while": "$n < 3", "steps": [
                                   {"do": "let", "values": {"n": "$n + 1"}}, {"do": "log", "text": "$text(n) "}]})",
                               R"({"n": 1})")),
              ElementsAre("2", "3"));
  EXPECT_THAT(said_by(sequence(R"({"do": "repeat", "until": "$n >= 1", "steps": [
                                   {"do": "let", "values": {"n": "$n + 1"}}, {"do": "log", "text": "$text(n) "}]})",
                               R"({"n": 1})")),
              ElementsAre("2"))
      << "asked after a round";
  EXPECT_THAT(said_by(R"({"do": "repeat", "while": false, "steps": [{"do": "log", "text": "never"}]})"), IsEmpty());
}

TEST_F(TreeTest, RepeatAsksSensorsToo) {
  const Program program =
      good(R"({"do": "repeat", "until": {"sensor": "wrist", "above_N": 50}, "steps": [)" + wait(10) + "]}");
  EXPECT_EQ(run(program, [this](int cycle, ProgramRunner&) { fake.extra.force.z() = cycle >= 55 ? 80 : 0; }),
            operations::Progress::kDone);
  EXPECT_GT(cycles, 55);
  EXPECT_LT(cycles, 80);
}

TEST_F(TreeTest, ALoopWithoutEndIsAnError) {
  EXPECT_EQ(run(R"({"do": "repeat", "while": true, "at_most": 5, "steps": [)" + wait(1) + "]}"),
            operations::Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program", {"5"}));
  EXPECT_EQ(run(R"({"do": "repeat", "while": true, "at_most": 1000000, "steps": []})"), operations::Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kTooLarge, "/program", {"10000"}));
  EXPECT_EQ(cycles, 0);
}

TEST_F(TreeTest, ForEachTakesListsAndGrids) {
  EXPECT_THAT(said_by(R"({"do": "for_each", "as": "c", "index": "i", "in": ["a", "b"],
                          "steps": [{"do": "log", "text": "$text(i) + c"}]})"),
              ElementsAre("0a", "1b"));
  EXPECT_THAT(said_by(R"({"do": "for_each", "as": "p", "grid": {"in": "block", "position_m": [0, 0, 0.1],
                          "count": [2, 1, 2], "step_m": [0.05, 0, 0.02]},
                          "steps": [{"do": "log", "text": "$text(magnitude(z(inverse(pose('block')) * p))) "}]})"),
              ElementsAre("0.1", "0.1", "0.12", "0.12"));
  EXPECT_THAT(said_by(sequence(R"({"do": "repeat", "times": 3, "as": "i", "steps": [
                 {"do": "let", "values": {"found": "$append(found, i * 2) "}}]},
               {"do": "for_each", "as": "x", "in": "$found", "steps": [{"do": "log", "text": "$text(x) "}]})",
                               R"({"found": {"type": "list of number", "value": []}})")),
              ElementsAre("0", "2", "4"));
}

TEST_F(TreeTest, ATextThatDoublesItselfIsRefusedInTheRehearsal) {
  const Diagnostics found = rehearsed(sequence(R"({"do": "repeat", "times": 40, "as": "i", "steps": [
                 {"do": "let", "values": {"word": "$word + word"}}]})",
                                               R"({"word": "ab"})"));
  ASSERT_EQ(found.list().size(), 1u) << found.to_string();
  EXPECT_EQ(found.list().front().pointer, "/program/steps/0/steps/0/values/word");
}

TEST_F(TreeTest, LoopsAreCheckedForForm) {
  EXPECT_THAT(refused(R"({"do": "repeat", "steps": []})"), ElementsAre("/program"));
  EXPECT_THAT(refused(R"({"do": "repeat", "times": -1, "as": "1", "steps": []})"),
              ElementsAre("/program/as", "/program/times"));
  EXPECT_THAT(refused(R"({"do": "repeat", "times": 2, "until": true, "steps": 5})"),
              ElementsAre("/program", "/program/steps"));
  EXPECT_THAT(refused(R"({"do": "for_each", "as": "x", "in": 5, "steps": []})"), ElementsAre("/program/in"));
  EXPECT_THAT(refused(R"({"do": "for_each", "in": [1, "a"], "grid": {}, "steps": []})"),
              ElementsAre("/program", "/program/grid", "/program/grid", "/program"));
  EXPECT_THAT(refused(R"({"do": "for_each", "as": "p", "grid": {"count": [2, 0.5, 2000], "step_m": [1, 1]},
                          "steps": []})"),
              ElementsAre("/program/grid/count/1", "/program/grid/count/2", "/program/grid/step_m"));
}

TEST_F(TreeTest, EveryElementIsRehearsed) {
  EXPECT_THAT(pointers(rehearsed(R"({"do": "for_each", "as": "z", "in": [0.1, 0.2, 3], "steps": [
      {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, "$z"]}}]})")),
              ElementsAre("/program/steps/0/to"));
}

// -- parallel ------------------------------------------------------------------------------------------------------

TEST_F(TreeTest, BranchesRunSideBySide) {
  const std::string both =
      R"({"do": "parallel", "branches": [)" + wait(20) + "," + sequence(wait(5) + "," + say("b")) + "]}";
  EXPECT_THAT(said_by(both), ElementsAre("b"));
  EXPECT_EQ(cycles, 20);
}

TEST_F(TreeTest, TheFirstEndsTheOthers) {
  const std::string race = R"({"do": "parallel", "end": "first", "branches": [)" + wait(20) + "," +
                           sequence(std::string(kMove) + "," + say("never")) + "]}";
  EXPECT_THAT(said_by(race), IsEmpty());
  EXPECT_TRUE(fake.core_arm().at_rest());
  EXPECT_FALSE(fake.core_arm().held());
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(TreeTest, AFailureEndsTheOtherBranches) {
  EXPECT_EQ(run(R"({"do": "parallel", "branches": [)" + std::string(kMove) + "," +
                sequence(wait(20) + R"(, {"do": "fail", "text": "no"})") + "]}"),
            operations::Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kRaised, "/program/branches/1/steps/1", {"no"}));
  EXPECT_TRUE(fake.core_arm().at_rest());
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(TreeTest, TwoBranchesMayNotDriveOneDevice) {
  const Diagnostics found = rehearsed(R"({"do": "parallel", "branches": [)" + std::string(kMove) + "," +
                                      sequence(wait(1) + "," + kMove) + "]}");
  EXPECT_THAT(pointers(found), ElementsAre("/program/branches/1"));
  EXPECT_THAT(found, Reports(Code::kResourceConflict, "/program/branches/1", {"arm", "0"}));
  EXPECT_THAT(refused(R"({"do": "parallel", "branches": [], "end": "frist"})"),
              ElementsAre("/program/end", "/program/branches"));
}

// -- call ----------------------------------------------------------------------------------------------------------

constexpr const char* kPrograms = R"({
  "twice": {"parameters": {"x": {"type": "number"}, "times": 2},
            "variables": {"y": 0},
            "steps": [{"do": "let", "values": {"y": "$x * times"}}], "result": "$y"},
  "outer": {"parameters": {"x": 1}, "variables": {"r": 0},
            "steps": [{"do": "call", "program": "twice", "with": {"x": "$x + 1"}, "as": "r"}], "result": "$r"}})";

TEST_F(TreeTest, ProgramsAreCalledWithParameters) {
  const auto program = with_programs(
      sequence(R"({"do": "call", "program": "outer", "with": {"x": 4}, "as": "n"},)" + say("$text(n)"), R"({"n": 0})"),
      kPrograms);
  ASSERT_TRUE(program) << program.error().to_string();
  EXPECT_EQ(run(*program), operations::Progress::kDone) << diagnostics.to_string();
  EXPECT_THAT(said(), ElementsAre("10"));
  EXPECT_TRUE(program->rehearse(fake.cell).diagnostics.empty());
}

TEST_F(TreeTest, CallsAreCheckedForForm) {
  const auto call = [&](const std::string& keys) {
    const auto program = with_programs(sequence(R"({"do": "call", )" + keys + "}", R"({"n": 0, "t": "a"})"), kPrograms);
    return program ? std::vector<std::string>() : pointers(program.error());
  };
  EXPECT_THAT(call(R"("program": "twcie")"), ElementsAre("/program/steps/0/program"));
  EXPECT_THAT(call(R"("program": "twice")"), ElementsAre("/program/steps/0/with"));
  EXPECT_THAT(call(R"("program": "twice", "with": {"x": "a", "z": 1})"),
              ElementsAre("/program/steps/0/with/x", "/program/steps/0/with/z"));
  EXPECT_THAT(call(R"("program": "twice", "with": {"x": 1}, "as": "m")"), ElementsAre("/program/steps/0/as"));
  EXPECT_THAT(call(R"("program": "twice", "with": {"x": 1}, "as": "t")"), ElementsAre("/program/steps/0/as"));
  EXPECT_THAT(call(R"("program": "outer")"), IsEmpty());
}

TEST_F(TreeTest, AProgramMayNotCallItself) {
  const auto program = with_programs(R"({"do": "call", "program": "a"})",
                                     R"({"a": {"steps": [{"do": "call", "program": "b"}]},
                                         "b": {"steps": [{"do": "call", "program": "a"}]}})");
  ASSERT_FALSE(program);
  EXPECT_THAT(pointers(program.error()), ElementsAre("/programs/b/steps/0/program"));
  EXPECT_THAT(program.error(), Reports(Code::kInvalidValue, "/programs/b/steps/0/program", {"a", "b"}));
}

TEST_F(TreeTest, AChainOfCallsHasAnEnd) {
  std::string programs = R"({"p0": {"steps": []})";
  for (int i = 1; i < 200; ++i) {
    programs +=
        ", \"p" + std::to_string(i) + R"(": {"steps": [{"do": "call", "program": "p)" + std::to_string(i - 1) + "\"}]}";
  }
  const auto program = with_programs(R"({"do": "call", "program": "p199"})", programs + "}");
  ASSERT_FALSE(program);
  EXPECT_THAT(program.error(), Reports(Code::kTooLarge, "/programs/p184/steps/0/program", {"16"}));
}

TEST_F(TreeTest, AProgramSeesNothingOfItsCaller) {
  const auto program = with_programs(sequence(R"({"do": "call", "program": "a"})", R"({"n": 0})"),
                                     R"({"a": {"steps": [{"do": "log", "text": "$text(n) "}]}})");
  ASSERT_FALSE(program);
  EXPECT_THAT(pointers(program.error()), ElementsAre("/programs/a/steps/0/text"));
}

// -- try, fail, stop -----------------------------------------------------------------------------------------------

TEST_F(TreeTest, AFailureIsHandled) {
  EXPECT_THAT(said_by(R"({"do": "try", "steps": [{"do": "fail", "text": "broken"}, {"do": "log", "text": "never"}],
      "on_error": {"as": "why", "steps": [{"do": "log", "text": "$'because: ' + why"}]},
      "finally": [{"do": "log", "text": "tidy"}]})"),
              ElementsAre("because: broken", "tidy"));
}

TEST_F(TreeTest, AFailureWithoutHandlerGoesOnUpAfterTidyingUp) {
  EXPECT_EQ(
      run(R"({"do": "try", "steps": [{"do": "fail", "text": "broken"}], "finally": [{"do": "log", "text": "tidy"}]})"),
      operations::Progress::kFailed);
  EXPECT_THAT(said(), ElementsAre("tidy"));
  EXPECT_THAT(diagnostics, Reports(Code::kRaised, "/program/steps/0", {"broken"}));
}

TEST_F(TreeTest, AnAttemptIsRepeated) {
  EXPECT_THAT(said_by(sequence(R"({"do": "try", "retry": 3, "recover": [{"do": "let", "values": {"n": "$n + 1"}}],
      "steps": [{"do": "branch", "cases": [{"when": "$n < 2", "steps": [{"do": "fail", "text": "not yet"}]}]},
                {"do": "log", "text": "$text(n) "}]})",
                               R"({"n": 0})")),
              ElementsAre("2"));
  EXPECT_EQ(run(R"({"do": "try", "retry": 2, "steps": [{"do": "log", "text": "x"}, {"do": "fail", "text": "never"}]})"),
            operations::Progress::kFailed);
  EXPECT_EQ(std::ranges::count(log, "program: log x"), 3);
}

TEST_F(TreeTest, AFailedMotionIsBrakedBeforeTheHandlerMoves) {
  const std::string program = R"({"do": "try", "steps": [{"do": "net", "net": "none"}]})";
  EXPECT_THAT(refused(program), Not(IsEmpty()));
  const Program guarded = good(sequence(
      R"({"do": "try", "steps": [{"do": "lin", "to": {"by_m": [0, 0, 0.1]},
                                    "until": {"sensor": "wrist", "above_N": 500}}],
          "on_error": {"steps": [{"do": "ptp", "to": "home"}]}})"));
  EXPECT_EQ(run(guarded, [this](int cycle, ProgramRunner&) { fake.sensor->silent = cycle >= 200 && cycle < 260; }),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(fake.q(), fake.arm->home);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(TreeTest, StopEndsTheProgramInOrder) {
  EXPECT_THAT(said_by(sequence(R"({"do": "try", "steps": [{"do": "stop"}], "on_error": {"steps": [)" + say("no") +
                               R"(]}, "finally": [)" + say("tidy") + "]}," + say("never"))),
              ElementsAre("tidy"));
}

TEST_F(TreeTest, TryIsCheckedForForm) {
  EXPECT_THAT(refused(R"({"do": "try", "steps": []})"), ElementsAre("/program"));
  EXPECT_THAT(refused(R"({"do": "try", "steps": [], "recover": [], "on_error": {"as": "1x", "setps": []}})"),
              ElementsAre("/program/on_error/as", "/program/on_error", "/program/on_error/setps", "/program/recover"));
  EXPECT_THAT(refused(R"({"do": "fail"})"), ElementsAre("/program"));
}

// -- wait for an expression ----------------------------------------------------------------------------------------

TEST_F(TreeTest, AWaitAsksAnExpressionEachCycle) {
  EXPECT_EQ(run(R"({"do": "wait", "until": "$time() >= 0.05[s]"})"), operations::Progress::kDone);
  EXPECT_EQ(fake.core.cycle(), 50);
  EXPECT_EQ(run(R"({"do": "wait", "until": "$false", "timeout_s": 0.02})"), operations::Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kTimeout, "/program/until", {"0.02"}));
}

// -- holding, single steps, state as data --------------------------------------------------------------------------

TEST_F(TreeTest, AHeldProgramBeginsNothing) {
  const Program program = good(sequence(wait(5) + "," + say("after")));
  EXPECT_EQ(run(program,
                [](int cycle, ProgramRunner& runner) {
                  if (cycle == 2) runner.hold(true);
                  if (cycle == 50) runner.hold(false);
                }),
            operations::Progress::kDone);
  EXPECT_EQ(cycles, 50);
}

TEST_F(TreeTest, SingleStepsBeginByPermissionOnly) {
  const Program program = good(sequence(say("a") + "," + say("b") + "," + say("c")));
  EXPECT_EQ(run(program,
                [this](int cycle, ProgramRunner& runner) {
                  if (cycle == 0) runner.set_single_step(true);
                  if (cycle == 10 || cycle == 20 || cycle == 30) runner.step();
                  if (cycle == 19) {
                    EXPECT_THAT(said(), ElementsAre("a"));
                  }
                  if (cycle == 29) {
                    EXPECT_THAT(said(), ElementsAre("a", "b"));
                  }
                }),
            operations::Progress::kDone);
  EXPECT_EQ(cycles, 30);
}

const char* const kLongProgram =
    R"({"do": "sequence", "variables": {"n": 0, "list": {"type": "list of pose", "value": []}},
  "steps": [
    {"do": "for_each", "as": "z", "in": [0.01, 0.02], "steps": [
      {"do": "repeat", "times": 2, "as": "i", "steps": [
        {"do": "call", "program": "count", "with": {"x": "$n"}, "as": "n"},
        {"do": "branch", "cases": [{"when": "$n > 1", "steps": [{"do": "wait", "seconds": 0.003}]}]},
        {"do": "let", "values": {"list": "$append(list, position('arm')) "}},
        {"do": "try", "steps": [{"do": "wait", "seconds": 0.002}, {"do": "log", "text": "$text(n) + text(z) "}],
         "finally": [{"do": "log", "text": "$text(i) "}]}]}]},
    {"do": "parallel", "branches": [{"do": "wait", "seconds": 0.004},
                                    {"do": "log", "text": "$text(length(list)) "}]}]})";
constexpr const char* kCount = R"({"count": {"parameters": {"x": {"type": "number"}}, "steps": [
    {"do": "wait", "seconds": 0.001}], "result": "$x + 1"}})";

TEST_F(TreeTest, D3_AProgramGoesOnFromItsStateAsData) {
  const auto program = with_programs(kLongProgram, kCount);
  ASSERT_TRUE(program) << program.error().to_string();
  ASSERT_EQ(run(*program), operations::Progress::kDone) << diagnostics.to_string();
  const auto whole = said();
  const int length = cycles;
  for (int at = 0; at < length; ++at) {
    SCOPED_TRACE(at);
    log.clear();
    nlohmann::ordered_json state;
    std::string text;
    std::vector<std::string> before;
    (void)run(*program, [&](int cycle, ProgramRunner& runner) {
      if (cycle == at) {
        text = runner.snapshot().dump();
        before = said();
      }
    });
    // A new runner, from the text.
    log.clear();
    ASSERT_EQ(go_on(*program, text), operations::Progress::kDone) << diagnostics.to_string();
    for (const std::string& line : said()) before.push_back(line);
    EXPECT_EQ(before, whole);
  }
}

// One branch has failed, the other one still brakes: the failure is part of the state.
TEST_F(TreeTest, D3_ARestoredParallelKnowsOfTheBranchThatHasFailed) {
  const Program program = good(R"({"do": "sequence", "steps": [{"do": "parallel", "branches": [
      {"do": "sequence", "steps": [{"do": "wait", "seconds": 0.8}, {"do": "fail", "text": "the part is lost"}]},
      {"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "velocity_m_s": 0.1}]}, {"do": "log", "text": "went on"}]})");
  std::vector<std::string> states;
  bool braked = false;
  EXPECT_EQ(run(program,
                [&](int cycle, ProgramRunner& runner) {
                  const bool failed = cycle > 812;  // the wait is over
                  braked = braked || (failed && !fake.core_arm().at_rest());
                  if (failed && cycle % 7 == 0) states.push_back(runner.snapshot().dump());
                }),
            operations::Progress::kFailed);
  ASSERT_TRUE(braked);
  ASSERT_GT(states.size(), 2u);
  for (const std::string& text : states) {
    const auto from = fake.q();
    EXPECT_EQ(go_on(program, text), operations::Progress::kFailed);
    EXPECT_THAT(diagnostics, Reports(Code::kRaised, "/program/steps/0/branches/0/steps/1"));
    EXPECT_EQ(diagnostics.list().size(), 1u) << diagnostics.to_string();
    EXPECT_TRUE(said().empty()) << "nothing goes on after it";
    EXPECT_EQ(fake.q(), from) << "and what was to end does not begin again";
  }
}

// The way on cannot be found while the motion that was left open for a blend still runs: it brakes, and the failure is
// part of the state.
TEST_F(TreeTest, D3_ARestoredSequenceKnowsThatItHasFailedWhileItsOpenMotionBrakes) {
  const std::string open = R"({"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "velocity_m_s": 0.1, "blend_m": 0.01})";
  const std::string fails = R"({"do": "sequence", "steps": [{"do": "log", "text": "once"},
      {"do": "repeat", "times": "$n", "steps": [{"do": "log", "text": "round"}]}]})";
  const auto declared = [](const std::string& steps) {
    return R"({"do": "sequence", "variables": {"n": -1}, "steps": [)" + steps + "]}";
  };
  const std::string after = R"({"do": "log", "text": "went on"})";
  for (const std::string& text :
       {declared(open + ", " + fails + ", " + after),
        declared(R"({"do": "parallel", "branches": [{"do": "sequence", "steps": [)" + open + ", " + fails + "]}]}")}) {
    SCOPED_TRACE(text);
    log.clear();
    const Program program = good(text);
    std::vector<std::string> states;
    EXPECT_EQ(run(program,
                  [&](int, ProgramRunner& runner) {
                    if (!said().empty()) states.push_back(runner.snapshot().dump());
                  }),
              operations::Progress::kFailed);
    const Diagnostics told = diagnostics;
    EXPECT_THAT(told, takt::test::ReportsAnywhere(Code::kOutOfRange, {"-1"}));
    // The motion has hardly begun when the program fails, so it takes a few cycles to stop.
    ASSERT_GT(states.size(), 3u) << "it brakes";
    for (std::size_t i = 0; i < states.size(); i += 2) {
      log.clear();
      const auto from = fake.q();
      EXPECT_EQ(go_on(program, states[i]), operations::Progress::kFailed);
      EXPECT_EQ(diagnostics.to_string(), told.to_string());
      EXPECT_TRUE(said().empty()) << "nothing is begun again, and nothing goes on after it";
      EXPECT_EQ(fake.q(), from) << "and what was to end does not begin again";
    }
    EXPECT_EQ(run(R"({"do": "ptp", "to": "home"})"), operations::Progress::kDone);
  }
}

TEST_F(TreeTest, D3_AForeignStateIsRefused) {
  const Program program = good(sequence(wait(1)));
  for (const char* text : {"{}", "5", R"({"measured": {}, "steps_done": 1, "position": {}})"}) {
    activity::Context context{fake.cell, fake.core, variables, latency, [](auto, auto, auto) {}};
    ProgramRunner runner(program, context);
    EXPECT_TRUE(runner.restore(test::Json::parse(text)).has_errors()) << text;
  }
}

TEST_F(TreeTest, AProgramIsEnteredAtAName) {
  const Program program = good(sequence(say("a") + R"(, {"do": "repeat", "times": 2, "steps": [)" + say("b") +
                                        R"(, {"do": "log", "name": "here", "text": "c"}]},)" + say("d")));
  const auto from = [&](const char* name) {
    log.clear();
    activity::Context context{
        fake.cell, fake.core, variables, latency, [this](auto source, auto event, auto line) {
          log.push_back(std::string(source) + ": " + std::string(event) + " " + std::string(line));
        }};
    ProgramRunner runner(program, context);
    const Diagnostics found = runner.enter(name);
    if (found.has_errors()) return std::vector<std::string>{std::string(name_of(found.list().front().code))};
    while (runner.advance() == operations::Progress::kRunning) fake.step();
    return said();
  };
  EXPECT_THAT(from("here"), ElementsAre("c", "b", "c", "d"));
  EXPECT_THAT(from("repeat"), ElementsAre("b", "c", "b", "c", "d"));
  EXPECT_THAT(from("hree"), ElementsAre("unknown-name"));
}

}  // namespace
}  // namespace takt::program
