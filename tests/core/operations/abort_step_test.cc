// What every operation that moves an arm has in common: "abort_if" (row N3); and values that are shown at a rate.
#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/interfaces/actuator_interfaces.h"
#include "tests/core/activity/command_fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;

class AbortStepTest : public test::CommandStepTest {
 protected:
  /// The operation, with the button as what must not hold; it is pressed after some cycles.
  /// @param most  cycles from there to the end
  void expect_aborted(const std::string& operation, const std::string& pointer = "/program/abort_if", int most = 400) {
    SCOPED_TRACE(operation);
    cell.button->sample.value = false;
    constexpr int kPressed = 300;
    EXPECT_EQ(run(good(operation),
                  [this](int cycle, program::ProgramRunner&) {
                    (void)cell.cell.channels.at("stick")->write(net::Twist{.linear = {0.02, 0, 0}});
                    (void)cell.cell.channels.at("enable")->write(true);
                    cell.button->sample.value = cycle >= kPressed;
                  }),
              Progress::kFailed);
    ASSERT_EQ(diagnostics.list().size(), 1U) << diagnostics.to_string();
    EXPECT_EQ(diagnostics.list().front().code, Code::kAbortCondition);
    EXPECT_EQ(diagnostics.list().front().pointer, pointer);
    EXPECT_LT(cycles, kPressed + most) << "it does not go on to its end";
    expect_good_end();
  }
  long count_of(const std::string& begin) const {
    return std::ranges::count_if(log, [&](const std::string& line) { return line.starts_with(begin); });
  }
  static std::string with_abort(const std::string& keys) {
    return "{" + keys + R"(, "abort_if": {"input": "button"}})";
  }
};

TEST_F(AbortStepTest, EveryOperationThatMovesAnArmEndsWhenItsAbortConditionHolds) {
  expect_aborted(with_abort(R"("do": "hold", "seconds": 5)"));
  expect_aborted(
      with_abort(R"("do": "jog", "channel": "stick", "in": "arm", "while": {"channel": "enable"}, "seconds": 5)"));
  expect_aborted(with_abort(R"("do": "follow", "in": "block", "linear_max_m_s": 0.001, "seconds": 5)"));
  expect_aborted(with_abort(R"("do": "press", "direction": [0, 0, -1], "in": "block", "approach_m_s": 0.001)"));
  expect_aborted(with_abort(R"("do": "search", "direction": [0, 0, -1], "in": "block", "approach_m_s": 0.001,
                               "radius_m": 0.01, "pitch_m": 0.004, "drop_m": 0.001)"));
  expect_aborted(with_abort(R"("do": "wipe", "in": "block", "approach_m_s": 0.001, "length_m": 0.02, "width_m": 0)"));
  constexpr int kWithModeChange = 1200;  // the springs become stiff first, then the mode changes back in 500 cycles
  expect_aborted(with_abort(R"("do": "freedrive", "seconds": 5)"), "/program/abort_if", kWithModeChange);
}

TEST_F(AbortStepTest, AnOperationOfATransactionSaysWhereItsAbortConditionStands) {
  expect_aborted(R"({"do": "transaction", "name": "t", "commands": {"stand": {"do": "hold", "start": true, "seconds": 5,
                     "abort_if": {"input": "button"}}}})",
                 "/program/commands/stand/abort_if");
}

TEST_F(AbortStepTest, N3_ASilentSensorInAnAbortConditionEndsIt) {
  EXPECT_EQ(run(good(R"({"do": "hold", "seconds": 5, "abort_if": {"sensor": "wrist", "above_N": 50}})"),
                [this](int cycle, program::ProgramRunner&) { cell.sensor->silent = cycle >= 300; }),
            Progress::kFailed);
  ASSERT_EQ(diagnostics.list().size(), 1U) << diagnostics.to_string();
  EXPECT_EQ(diagnostics.list().front().code, Code::kSensorSilent);
  EXPECT_EQ(diagnostics.list().front().pointer, "/program/abort_if");
}

TEST_F(AbortStepTest, SaysWhatWasComparedWithWhichBound) {
  for (const char* operation :
       {R"("do": "hold", "seconds": 5)", R"("do": "lin", "to": {"by_m": [0, 0, 0.1]}, "speed": 0.05)",
        R"("do": "transaction", "name": "t", "commands": {"up": {"do": "lin", "start": true,
           "to": {"by_m": [0, 0, 0.1]}, "speed": 0.05, ABORT}})"}) {
    SCOPED_TRACE(operation);
    cell.extra = {};
    const std::string condition = R"("abort_if": {"any": [{"sensor": "wrist", "above_N": 50}, {"input": "button"}]})";
    std::string text = operation;
    if (const auto place = text.find("ABORT"); place != std::string::npos) text.replace(place, 5, condition);
    const bool inside = text != operation;
    EXPECT_EQ(run(good(inside ? "{" + text + "}" : "{" + text + ", " + condition + "}"),
                  [this](int cycle, program::ProgramRunner&) {
                    cell.button->sample.value = false;
                    if (cycle >= 300) cell.extra.force = {60.0, 0.0, 0.0};
                  }),
              Progress::kFailed);
    EXPECT_THAT(diagnostics,
                Reports(Code::kAbortCondition, inside ? "/program/commands/up/abort_if" : "/program/abort_if",
                        {"wrist above 50"}));
  }
}

TEST_F(AbortStepTest, WhereItNeverHoldsTheOperationEndsInOrder) {
  EXPECT_EQ(run(with_abort(R"("do": "hold", "seconds": 0.2)")), Progress::kDone) << diagnostics.to_string();
}

TEST_F(AbortStepTest, ACaptureWithARateIsShownWhileItsTransactionRuns) {
  const auto with_rate = [](const char* more) {
    return fmt::format(R"({{"do": "transaction", "name": "t", "commands": {{
        "up": {{"do": "lin", "start": true, "to": {{"by_m": [0, 0, 0.1]}}}}}},
        "capture": {{"way": {{"value": {{"progress": "up"}}, "rate_Hz": 100{}}}}}}})",
                       more);
  };
  const program::Program program = good(with_rate(""));
  std::vector<double> seen;
  ASSERT_EQ(run(program,
                [&](int, program::ProgramRunner&) {
                  const std::string& text = variables.monitors["t"]["way"];
                  if (text.empty() || text == "null") return;
                  if (seen.empty() || seen.back() != std::stod(text)) seen.push_back(std::stod(text));
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_GT(seen.size(), 20U);
  EXPECT_TRUE(std::ranges::is_sorted(seen));
  EXPECT_NEAR(static_cast<double>(count_of("t: way")), cycles / 10.0, 3.0) << "a hundred times a second";
  EXPECT_EQ(wrong(with_rate(R"(, "when": {"completed": "up"})")).list().front().pointer,
            "/program/capture/way/rate_Hz");
}

TEST_F(AbortStepTest, AProgramInCppGivesTheSameParameter) {
  activity::Runtime program(cell.core, cell.cell, [this] { cell.step(); });
  const app::Actuator robot(program, "arm");
  expression::Condition button;
  button.kind = expression::Condition::Kind::kDigital;
  button.device = "button";
  for (const activity::Activity& one :
       {robot.use<app::HoldInterface>().hold({.seconds = 5.0, .abort_if = button}),
        robot.use<app::FreedriveInterface>().freedrive({.seconds = 5.0, .abort_if = button})}) {
    SCOPED_TRACE(one.model()->name());
    const activity::RunPtr run = one.schedule();
    for (int i = 0; i < 2000 && !run->over(); ++i) {
      cell.button->sample.value = i > 300;
      program.step();
    }
    ASSERT_EQ(run->state(), activity::RunState::kFailed);
    EXPECT_EQ(run->failure(), activity::RunFailure::kAborted);
    ASSERT_FALSE(run->diagnostics().empty());
    EXPECT_EQ(run->diagnostics().list().front().code, Code::kAbortCondition);
    EXPECT_TRUE(run->diagnostics().list().front().pointer.ends_with("/abort_if"));
  }
}

}  // namespace
}  // namespace takt::operations
