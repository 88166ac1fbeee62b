// Programs: their form, their rehearsal, and running them on an arm without a body.
#include "core/program/tree/program.h"

#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"

namespace takt::program {
namespace {

using takt::test::Reports;
using testing::ElementsAre;
using testing::IsEmpty;

class ProgramTest : public test::ActivityTest {
 protected:
  Diagnostics rehearsed(const std::string& text) const { return good(text).rehearse(fake.cell).diagnostics; }
  static std::string sequence(const std::string& steps, const std::string& more = "") {
    return R"({"do": "sequence", "steps": [)" + steps + "]" + more + "}";
  }
};

constexpr const char* kWait = R"({"do": "wait", "seconds": 0.01})";
constexpr const char* kToTheBlock =
    R"({"do": "ptp", "name": "there", "to": {"in": "block", "position_m": [0, 0, 0.1]}, "speed": 0.5})";

// -- Form ----------------------------------------------------------------------------------------------------------

TEST_F(ProgramTest, ATreeKnowsItsNamesAndItsSteps) {
  const Program program = good(sequence(
      std::string(kWait) + "," + sequence(std::string(kWait) + "," + kToTheBlock, R"(, "name": "inner", "times": 3)"),
      R"(, "times": 2)"));
  EXPECT_THAT(program.names(), ElementsAre("sequence", "wait", "inner", "wait", "there"));
  EXPECT_EQ(program.step_count(), 2 * (1 + 3 * 2));
}

TEST_F(ProgramTest, AllErrorsOfFormAreFoundAtOnce) {
  EXPECT_THAT(
      refused(sequence(R"({"do": "wiat", "seconds": 1}, {"seconds": 1}, 5,
      {"do": "wait", "seconds": -1}, {"do": "ptp"},
      {"do": "lin", "arm": "amr", "to": "home", "spede": 1},
      {"do": "tare", "sensor": "writs"}, {"do": "record_contact"},
      {"do": "fit_pose", "object": "blok", "as": "x", "contacts": [], "free": ["x", "w"]})")),
      ElementsAre("/program/steps/0/do", "/program/steps/1/do", "/program/steps/2", "/program/steps/3/seconds",
                  "/program/steps/4", "/program/steps/5/arm", "/program/steps/5/spede", "/program/steps/6/sensor",
                  "/program/steps/7", "/program/steps/8/object", "/program/steps/8/free/1"));
  EXPECT_THAT(parse(R"({"do": "wiat"})").error(), Reports(Code::kUnknownName, "/program/do", {"wait"}));
}

TEST_F(ProgramTest, AnEstimateMayNotTakeTheNameOfSomethingElse) {
  const auto fit = [](const char* as) {
    return std::string(R"({"do": "fit_pose", "object": "block", "contacts": ["a"], "free": ["x"], "as": ")") + as +
           "\"}";
  };
  EXPECT_THAT(refused(fit("arm")), ElementsAre("/program/as"));
  EXPECT_THAT(refused(fit("world")), ElementsAre("/program/as"));
  EXPECT_THAT(refused(fit("block")), IsEmpty());
  EXPECT_THAT(refused(fit("block found")), IsEmpty());
}

// -- Rehearsal -----------------------------------------------------------------------------------------------------

TEST_F(ProgramTest, RehearsalFindsWhatCannotBeReached) {
  const Diagnostics found = rehearsed(sequence(R"(
      {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 3]}},
      {"do": "ptp", "to": {"joints_deg": [0, 0, 0, 170, 0, 0, 0]}},
      {"do": "lin", "to": {"by_m": [0, 2, 0]}},
      {"do": "lin", "to": {"in": "nowhere", "position_m": [0, 0, 0]}})"));
  EXPECT_THAT(pointers(found),
              ElementsAre("/program/steps/0/to", "/program/steps/1/to", "/program/steps/2/to", "/program/steps/3/to"));
  EXPECT_THAT(found, Reports(Code::kUnreachable, "/program/steps/0/to"));
  EXPECT_THAT(found, Reports(Code::kUnknownName, "/program/steps/3/to", {"nowhere"}));
}

TEST_F(ProgramTest, RehearsalFollowsTheArmFromStepToStep) {
  const std::string up = R"({"do": "lin", "to": {"by_m": [0, 0, 0.15]}})";
  EXPECT_THAT(pointers(rehearsed(sequence(up, R"(, "times": 1)"))), IsEmpty());
  EXPECT_THAT(pointers(rehearsed(sequence(up + "," + up + "," + up + "," + up + "," + up))),
              testing::Contains("/program/steps/4/to"))
      << "five times up leads out of reach, once does not";
}

TEST_F(ProgramTest, RehearsalKnowsContactsAndFits) {
  const std::string touch =
      R"({"do": "lin", "to": {"by_m": [0, 0, -0.02]}, "until": {"sensor": "wrist", "above_N": 5}})";
  const std::string record = R"({"do": "record_contact", "as": "top"})";
  const std::string fit = R"({"do": "fit_pose", "object": "block", "as": "found", "contacts": ["top"], "free": ["z"]})";
  const std::string there = R"({"do": "ptp", "to": {"in": "found", "position_m": [0, 0, 0.1]}})";
  EXPECT_THAT(pointers(rehearsed(sequence(touch + "," + record + "," + fit + "," + there))), IsEmpty());
  EXPECT_THAT(pointers(rehearsed(sequence(there))), ElementsAre("/program/steps/0/to")) << "nothing defines it";
  EXPECT_THAT(pointers(rehearsed(sequence(kToTheBlock + std::string(",") + record))), ElementsAre("/program/steps/1"))
      << "no guarded motion before";
  EXPECT_THAT(pointers(rehearsed(sequence(touch + "," + record +
                                          R"(, {"do": "fit_pose", "object": "block", "as": "f", "contacts": ["tpo"],
                                               "free": ["x", "z"]})"))),
              ElementsAre("/program/steps/2/contacts/0", "/program/steps/2/contacts"))
      << "an unknown contact, and fewer contacts than coordinates";
}

TEST_F(ProgramTest, RehearsalMeasuresRepetitionsButDoesNotPlayThemAll) {
  const Rehearsed rehearsal = good(sequence(kWait, R"(, "times": 1000000)")).rehearse(fake.cell);
  EXPECT_TRUE(rehearsal.diagnostics.empty());
  EXPECT_NEAR(rehearsal.duration, 10'000.0, 1e-3);
  std::string nested = kWait;
  for (int i = 0; i < 25; ++i) nested = sequence(nested, R"(, "times": 2)");
  EXPECT_NEAR(good(nested).rehearse(fake.cell).duration, 0.01 * (1 << 25), 1e-3);
  for (int i = 0; i < 4; ++i) nested = sequence(nested, R"(, "times": 1000000)");
  EXPECT_EQ(good(nested).step_count(), 1'000'000'000'000);
}

// -- Running -------------------------------------------------------------------------------------------------------

TEST_F(ProgramTest, StepsRunInTheOrderOfTheTree) {
  EXPECT_EQ(
      run(sequence(
          R"({"do": "wait", "seconds": 0.003, "name": "a"},)" +
              sequence(R"({"do": "wait", "seconds": 0, "name": "b"}, {"do": "wait", "seconds": 0.002, "name": "c"})",
                       R"(, "times": 2)") +
              "," + sequence(kWait, R"(, "times": 0)") + "," + sequence(""),
          R"(, "times": 2)")),
      operations::Progress::kDone);
  std::vector<std::string> begun;
  for (const std::string& line : log) {
    if (line.starts_with("program: begin ")) begun.push_back(line.substr(15));
  }
  EXPECT_THAT(begun, ElementsAre("a", "b", "c", "b", "c", "a", "b", "c", "b", "c"));
  EXPECT_EQ(cycles, 2 * (3 + 2 * 2));
  EXPECT_EQ(steps_done, 10);
}

TEST_F(ProgramTest, AMotionGoesToItsGoal) {
  EXPECT_EQ(run(sequence(std::string(kToTheBlock) + R"(, {"do": "lin", "to": {"by_m": [0, 0, 0.05], "in": "block"}},
      {"do": "ptp", "to": "home"})")),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(fake.q(), fake.arm->home);
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(ProgramTest, D1_AProgramThatNeverWaitsIsStopped) {
  EXPECT_EQ(run(sequence(R"({"do": "wait", "seconds": 0, "name": "busy"})", R"(, "times": 1000000)")),
            operations::Progress::kFailed);
  EXPECT_EQ(cycles, 0) << "before a cycle";
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/steps/0"));
  EXPECT_THAT(diagnostics, Reports(Code::kTooLarge, "/program/steps/0", {"10000"}));
  EXPECT_EQ(steps_done, 10'000);
  EXPECT_EQ(run(sequence(R"({"do": "wait", "seconds": 0})", R"(, "times": 9999)")), operations::Progress::kDone);
}

TEST_F(ProgramTest, D1_RoundsOfNothingAreNotPlayed) {
  std::string empty = sequence("");
  for (int i = 0; i < 5; ++i) empty = sequence(empty, R"(, "times": 1000000)");
  EXPECT_EQ(run(sequence(empty + "," + kWait)), operations::Progress::kDone);
  EXPECT_EQ(cycles, 10);
}

TEST_F(ProgramTest, AFailingStepNamesItself) {
  const Program program = good(sequence(std::string(kWait) + R"(,
      {"do": "lin", "name": "nothing there", "to": {"by_m": [0, 0, 0.02]}, "until": {"sensor": "wrist", "above_N": 50}},
      {"do": "wait", "seconds": 1})"));
  EXPECT_EQ(run(program), operations::Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/steps/1/until"));
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program/steps/1/until"));
  EXPECT_THAT(log.back(), testing::StartsWith("program: failed nothing there: ")) << "nothing follows";
  EXPECT_EQ(log.back().substr(31), diagnostics.list().at(0).message) << "and why is told";
}

TEST_F(ProgramTest, AFaultOfTheArmIsTheFailureOfItsStep) {
  const Program program = good(sequence(kToTheBlock));
  EXPECT_EQ(run(program, [this](int cycle, ProgramRunner&) { fake.backend->silent = cycle >= 200; }),
            operations::Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/steps/0"));
  EXPECT_THAT(diagnostics, Reports(Code::kStopped, "/program/steps/0"));
}

TEST_F(ProgramTest, N3_ASensorThatFallsSilentIsNoTouch) {
  const std::string touch =
      R"({"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "until": {"sensor": "wrist", "above_N": 9}, "on_end": "continue"})";
  EXPECT_EQ(run(good(touch), [this](int cycle, ProgramRunner&) { fake.sensor->silent = cycle >= 300; }),
            operations::Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kSensorSilent, "/program/until"));
  EXPECT_THAT(variables.touches, IsEmpty());
  EXPECT_TRUE(fake.core_arm().at_rest());
}

TEST_F(ProgramTest, L6_ACancelEndsTheStepAndTheProgram) {
  const Program program = good(sequence(std::string(kToTheBlock) + "," + kWait));
  // From before the net is started to the middle of the motion; the arm must come to rest each time.
  for (const int at : {0, 1, 2, 3, 4, 5, 50, 300}) {
    SCOPED_TRACE(at);
    EXPECT_EQ(run(program,
                  [at](int cycle, ProgramRunner& runner) {
                    if (cycle == at) runner.cancel();
                  }),
              operations::Progress::kDone);
    EXPECT_LT(cycles, at + 400) << "the bound of this motion, not that of the core";
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
    EXPECT_TRUE(fake.core_arm().at_rest());
    EXPECT_THAT(log, testing::Not(testing::Contains("program: begin wait")));
    EXPECT_EQ(run(R"({"do": "ptp", "to": "home"})"), operations::Progress::kDone) << "the arm is free again";
  }
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(ProgramTest, ManyStepsDoNotFillTheCore) {
  EXPECT_EQ(run(sequence(R"({"do": "tare", "cycles": 1})", R"(, "times": 5000)")), operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(steps_done, 5000);
}

}  // namespace
}  // namespace takt::program
