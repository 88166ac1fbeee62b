// A motion goes on with the last motion of a transaction, without a stop (rows P4, L8, L9).
#include <algorithm>
#include <string>
#include <vector>

#include "app/interfaces/actuator_interfaces.h"
#include "core/activity/command_activity.h"
#include "tests/core/activity/command_fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using testing::Contains;
using testing::HasSubstr;

class LeftTransactionTest : public test::CommandStepTest {
 protected:
  LeftTransactionTest()
      : CommandStepTest([](test::CommandCell& own) {
          const Diagnostics wrong = activity::declare_channels(own.core, own.cell);
          EXPECT_FALSE(wrong.has_errors()) << wrong.to_string();
        }) {}

  /// The lamp is lit, then the arm goes up; then, outside, to the side.
  static std::string up_and_aside(const std::string& blend, const std::string& more = "",
                                  const std::string& aside = R"("to": {"by_m": [0, 0.1, 0]})") {
    return R"({"do": "sequence", "steps": [{"do": "transaction", "name": "t", "commands": {
        "lamp": {"do": "set", "start": true, "output": "lamp", "value": true},
        "up": {"do": "lin", "to": {"by_m": [0, 0, 0.1]})" +
           blend + R"(}}, "on": [{"entered": {"completed": "lamp"}, "start": "up"})" + more +
           R"(]}, {"do": "lin", "name": "aside", )" + aside + "}]}";
  }
  static constexpr const char* kBlend = R"(, "blend_m": 0.04)";

  /// Runs it and counts the cycles in which the arm stood between its first and its last motion.
  int standing(const program::Program& program, const AtCycle& at_cycle = {}) {
    std::vector<double> speeds;
    EXPECT_EQ(run(program,
                  [&](int cycle, program::ProgramRunner& runner) {
                    if (at_cycle) at_cycle(cycle, runner);
                    speeds.push_back(speed());
                  }),
              Progress::kDone)
        << diagnostics.to_string();
    const auto moves = [](double speed) { return speed > 1e-4; };
    const auto first = std::ranges::find_if(speeds, moves);
    const auto last = std::find_if(speeds.rbegin(), speeds.rend(), moves).base();
    return static_cast<int>(std::count_if(first, last, [&](double one) { return !moves(one); }));
  }
};

TEST_F(LeftTransactionTest, TheNextMotionGoesOnWithTheLastOneOfATransaction) {
  const Eigen::Vector3d from = tool();
  const int stop = standing(good(up_and_aside("")));
  EXPECT_GT(stop, 0) << "without a blend it comes to rest";
  const int cycles_with_stop = cycles;
  ASSERT_EQ(run(R"({"do": "ptp", "to": "home"})"), Progress::kDone);
  log.clear();
  const program::Program program = good(up_and_aside(kBlend));
  EXPECT_TRUE(rehearsed.list().empty()) << rehearsed.to_string();
  EXPECT_EQ(standing(program), 0);
  EXPECT_LT(cycles, cycles_with_stop);
  EXPECT_LT((tool() - from - Eigen::Vector3d(0, 0.1, 0.1)).norm(), 1e-6);
  EXPECT_TRUE(lamp());
  EXPECT_THAT(begun(), testing::ElementsAre("t", "aside"));
  EXPECT_THAT(log, Contains("program: end t"));
  expect_good_end();
}

TEST_F(LeftTransactionTest, SeveralMotionsOfATransactionAreLeftAtTheirLast) {
  const program::Program program = good(R"({"do": "sequence", "steps": [{"do": "transaction", "name": "t", "commands": {
        "round": {"do": "motions", "start": true, "steps": [{"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "blend_m": 0.03},
                  {"do": "lin", "to": {"by_m": [0, 0.1, 0]}, "blend_m": 0.03}]}}},
        {"do": "lin", "to": {"by_m": [0, 0, -0.1]}}]})");
  EXPECT_EQ(standing(program), 0);
  expect_good_end();
}

TEST_F(LeftTransactionTest, WithoutAMotionBehindItItComesToItsGoal) {
  const Eigen::Vector3d from = tool();
  const program::Program program = good(R"({"do": "transaction", "name": "t", "commands": {
      "up": {"do": "lin", "start": true, "to": {"by_m": [0, 0, 0.1]}, "blend_m": 0.04}}})");
  EXPECT_THAT(rehearsed, takt::test::ReportsAnywhere(Code::kNote));
  ASSERT_EQ(run(program), Progress::kDone) << diagnostics.to_string();
  EXPECT_LT((tool() - from - Eigen::Vector3d(0, 0, 0.1)).norm(), 1e-6);
}

TEST_F(LeftTransactionTest, WhatMayStillHappenForbidsIt) {
  const auto expect_refused = [this](const std::string& program) {
    const Diagnostics found = wrong(program);
    ASSERT_EQ(found.list().size(), 1U) << found.to_string();
    EXPECT_EQ(found.list().front().code, Code::kConflict);
    EXPECT_EQ(found.list().front().pointer, "/program/steps/0/commands/up");
  };
  // Its end starts something, is told, or something else runs beside it.
  expect_refused(up_and_aside(kBlend, R"(, {"entered": {"completed": "up"}, "tell": "there"})"));
  expect_refused(up_and_aside(kBlend, R"(, {"entered": {"input": "button"}, "cancel": "up"})"));
  expect_refused(up_and_aside(R"(, "blend_m": 0.04}, "beside": {"do": "wait", "start": true, "seconds": 3)"));
}

TEST_F(LeftTransactionTest, WhatMustNotHoldCountsOnTheRestOfItToo) {
  const program::Program program = good(up_and_aside(R"(, "blend_m": 0.04, "abort_if": {"input": "button"})"));
  EXPECT_EQ(standing(program), 0);
  ASSERT_EQ(run(R"({"do": "ptp", "to": "home"})"), Progress::kDone);
  EXPECT_EQ(
      run(program, [this](int, program::ProgramRunner&) { cell.button->sample.value = lamp() && speed() > 0.02; }),
      Progress::kFailed);
  EXPECT_EQ(diagnostics.list().front().code, Code::kAbortCondition) << diagnostics.to_string();
  cell.button->sample.value = false;
  expect_good_end();
}

TEST_F(LeftTransactionTest, L6_ACancelAtAnyCycleEndsInOrder) {
  const program::Program program = good(up_and_aside(kBlend)), home = good(R"({"do": "ptp", "to": "home"})");
  ASSERT_EQ(run(program), Progress::kDone);
  const int whole = cycles;
  ASSERT_EQ(run(home), Progress::kDone);
  for (int at = 0; at < whole; at += whole / 20) {
    SCOPED_TRACE(at);
    ASSERT_EQ(run(program, cancelling(at)), Progress::kDone) << diagnostics.to_string();
    EXPECT_TRUE(cell.core_arm().at_rest());
    ASSERT_EQ(run(home), Progress::kDone) << diagnostics.to_string();
  }
  expect_good_end();
}

TEST_F(LeftTransactionTest, WhatHasFailedBeforeTheLastMotionEndsTheStep) {
  const program::Program program = good(R"({"do": "sequence", "steps": [{"do": "transaction", "name": "t", "commands": {
      "grip": {"do": "grip", "start": true}, "up": {"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "blend_m": 0.04}},
      "on": [{"entered": {"completed": "grip"}, "start": "up"}]}, {"do": "lin", "to": {"by_m": [0, 0.1, 0]}}]})");
  EXPECT_EQ(run(program,
                [this](int, program::ProgramRunner&) {
                  if (!cell.fingers->written.empty()) cell.fingers->answer(device::GripperState::kIdle, 0.0);
                }),
            Progress::kFailed);
  ASSERT_FALSE(diagnostics.empty());
  EXPECT_EQ(diagnostics.list().front().code, Code::kConditionNotMet) << diagnostics.to_string();
  EXPECT_EQ(diagnostics.list().front().pointer, "/program/steps/0/commands/grip");
  EXPECT_LT(cycles, 1500) << "it does not wait for the end of the motion";
  expect_good_end();
}

// Row D3: the motion is begun again, from where the arm is, and the program goes on with it.
TEST_F(LeftTransactionTest, D3_ASnapshotKnowsTheMotionThatWasLeft) {
  std::string steps = up_and_aside(kBlend);
  steps.replace(steps.find(R"({"do": "lin", "name": "aside")"), 0, R"({"do": "log", "text": "x"}, )");
  const Eigen::Vector3d from = tool();
  const program::Program program = good(steps);
  const std::string snapshot =
      snapshot_when(program, [&](const program::ProgramRunner&) { return tool().z() - from.z() > 0.02; });
  ASSERT_THAT(snapshot, HasSubstr("\"open\""));
  const Eigen::Vector3d there = tool();
  ASSERT_EQ(go_on(program, snapshot), Progress::kDone) << diagnostics.to_string();
  EXPECT_LT((tool() - there - Eigen::Vector3d(0, 0.1, 0.1)).norm(), 1e-6)
      << "the motion, and not the whole transaction, is begun again";
}

TEST_F(LeftTransactionTest, AProgramInCppGoesOnWithACommand) {
  activity::Runtime program(cell.core, cell.cell, [this] { cell.step(); });
  program.step();
  const app::Actuator robot(program, "arm");
  command::TransactionCommand both("both");
  const command::RuntimeCommand lit("lit", cell.lamp(), command::set_value(true));
  const command::RuntimeCommand up(
      "up", cell.arm_actuator(),
      command::lin(cell.moved(0, 0, 0.1), {.blend = {motion::Blend::Kind::kDistance, 0.04}}));
  both.add_started(lit).add(up);
  both.on_entered(lit.completed(), start(up));
  const activity::RunPtr first = program.schedule(activity::command_activity(both));
  const activity::RunPtr next = robot.use<app::LinInterface>().lin(cell.moved(0, 0.1, 0.1)).schedule();
  for (int i = 0; i < 10'000 && !next->over(); ++i) program.step();
  EXPECT_EQ(first->state(), activity::RunState::kCompleted) << first->diagnostics().to_string();
  EXPECT_EQ(next->state(), activity::RunState::kCompleted) << next->diagnostics().to_string();
  EXPECT_TRUE(next->blended());
  EXPECT_TRUE(lamp());
}

}  // namespace
}  // namespace takt::operations
