// Commands in a control core: start, schedule, cancel, abort, wait, external effects, what a failure tells.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/activity/activity.h"
#include "core/activity/runtime.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::command {
namespace {

using takt::test::Reports;

using net::Cause;
using rcc::NetState;

class CommandRunTest : public testing::Test {
 protected:
  RuntimeCommand move(double a1, double velocity = 0.5) const {
    return {"move", cell.arm_actuator(), ptp(cell.joints(a1), {.velocity = velocity})};
  }
  LoadedCommand load(const Command& command) {
    auto handle = cell.runtime.load(command);
    if (!handle) ADD_FAILURE() << handle.error().to_string();
    return handle.value();
  }
  test::CommandCell cell;
};

TEST_F(CommandRunTest, ExecuteRunsToTheGoal) {
  const CommandStatus status = cell.runtime.execute(move(0.3));
  EXPECT_TRUE(status.succeeded()) << status.to_string();
  EXPECT_NEAR(cell.q()[0], cell.arm->home[0] + 0.3, 1e-12);
  EXPECT_GT(status.last_cycle, status.first_cycle);
  EXPECT_TRUE(status.last_cycles.empty()) << "nothing to explain";
}

TEST_F(CommandRunTest, ASecondCommandOfTheSameArmIsPlannedFromTheEndOfTheFirst) {
  activity::Runtime program(cell.core, cell.cell, [this] { cell.step(); });
  const activity::Activity there(program, activity::command_activity(move(0.3))),
      back(program, activity::command_activity(move(0.0)));
  const activity::RunPtr first = there.schedule(), second = back.schedule();
  wait(program, second);
  EXPECT_EQ(first->state(), activity::RunState::kCompleted) << first->diagnostics().to_string();
  EXPECT_GT(second->first_cycle(), first->last_cycle());
  EXPECT_LT((cell.q() - cell.arm->home).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(CommandRunTest, CancelBrakesOnThePathAndAbortStops) {
  LoadedCommand cancelled = load(move(0.6));
  cancelled.start();
  for (int i = 0; i < 300; ++i) cell.runtime.step();
  cancelled.cancel();
  EXPECT_EQ(cancelled.wait(2000).cause.code, Cause::Code::kCancelled);
  EXPECT_TRUE(cell.core_arm().at_rest());
  LoadedCommand aborted = load(move(0.9));
  aborted.start();
  for (int i = 0; i < 300; ++i) cell.runtime.step();
  aborted.abort();
  const CommandStatus status = aborted.wait(10);
  EXPECT_EQ(status.cause.code, Cause::Code::kAborted);
  EXPECT_FALSE(status.succeeded());
  cell.step(2000);
  EXPECT_TRUE(cell.core_arm().at_rest());
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(CommandRunTest, BeforeTheStartACancelMeansThatItNeverBegins) {
  LoadedCommand handle = load(move(0.3));
  handle.cancel();
  handle.start();
  EXPECT_EQ(handle.wait(10).state, activity::RunState::kCancelled);
  cell.step(10);
  EXPECT_EQ(cell.q(), cell.arm->home);
}

TEST_F(CommandRunTest, StartAndCancelAreNotLostWhenTheCoresQueueIsFull) {
  const auto fill = [this] {
    while (cell.core.cancel(4711) != 0) continue;
  };
  LoadedCommand handle = load(move(0.6)), never = load(move(0.6));
  fill();
  handle.start();
  never.start();
  never.cancel();
  for (int i = 0; i < 300; ++i) cell.runtime.step();
  EXPECT_EQ(handle.status().state, activity::RunState::kRunning);
  EXPECT_EQ(never.status().state, activity::RunState::kCancelled) << "its start was never posted";
  fill();
  handle.cancel();
  EXPECT_EQ(handle.wait(2000).cause.code, Cause::Code::kCancelled);
}

TEST_F(CommandRunTest, ARefusedStartSaysWhoHoldsTheArm) {
  LoadedCommand first = load(move(0.6)), second = load(move(-0.6));
  first.start();
  cell.runtime.step();
  second.start();
  const CommandStatus status = second.wait(10);
  EXPECT_TRUE(status.ended());
  EXPECT_THAT(status.diagnostics, Reports(Code::kNotPossibleNow, "/move", {"move"}));
  EXPECT_EQ(second.run()->failure(), activity::RunFailure::kRefused);
}

TEST_F(CommandRunTest, AFailureTellsTheLastSixteenCycles) {
  RuntimeCommand moved = move(0.6);
  moved.on_entered(cell.hard(), external("felt"));
  LoadedCommand handle = load(moved);
  handle.start();
  for (int i = 0; i < 200; ++i) cell.runtime.step();
  cell.backend->state().ready = false;
  const CommandStatus status = handle.wait(100);
  EXPECT_EQ(status.cause.code, Cause::Code::kDevice) << status.to_string();
  ASSERT_EQ(status.last_cycles.size(), activity::RunTrace::kCycles);
  EXPECT_EQ(status.last_cycles.back().cycle, status.last_cycle);
  EXPECT_THAT(status.to_string(),
              testing::AllOf(testing::HasSubstr("/move q="), testing::HasSubstr("/move/handlers/0=false")));
}

TEST_F(CommandRunTest, ExternalEffectsAreCountedAndNoneIsLost) {
  std::vector<ExternalEvent> events;
  WaitCommand wait("wait", 0.5);
  wait.on_entered(expression::digital_input(cell.cell, "button"),
                  external("pressed", [&events](const ExternalEvent& event) { events.push_back(event); }));
  wait.on_entered(expression::digital_input(cell.cell, "button"), external("first", {}), {.first_only = true});
  LoadedCommand handle = load(wait);
  handle.start();
  cell.runtime.step();
  const auto press = [this](bool down) {
    cell.button->sample.value = down;
    cell.step();
  };
  for (int i = 0; i < 10; ++i) {  // nobody polls
    press(true);
    press(false);
  }
  cell.runtime.poll();
  ASSERT_EQ(events.size(), 10u);
  for (std::size_t i = 0; i < events.size(); ++i) EXPECT_EQ(events[i].count, static_cast<std::int64_t>(i) + 1);
  EXPECT_EQ(*events[1].cycle, *events[0].cycle + 2) << "each has its cycle";
  for (int i = 0; i < 50; ++i) {  // more cycles than the queue holds
    press(true);
    press(false);
  }
  cell.runtime.poll();
  EXPECT_EQ(events.size(), 60u) << "none is lost";
  EXPECT_GT(handle.run()->external_times_lost(), 0) << "but when some of them were";
  EXPECT_EQ(events.back().cycle, std::nullopt);
}

TEST_F(CommandRunTest, AHandlerOutsideMayStartTheNextCommand) {
  LoadedCommand next = load(RuntimeCommand("lamp", cell.lamp(), set_value(true)));
  RuntimeCommand moved = move(0.3);
  moved.on_entered(moved.action().at_path(0.5), external("half", [&next](const ExternalEvent&) { next.start(); }));
  LoadedCommand handle = load(moved);
  handle.start();
  EXPECT_TRUE(handle.wait().succeeded());
  EXPECT_TRUE(next.status().succeeded());
  EXPECT_TRUE(cell.cell.digital_outputs.at("lamp")->value());
}

TEST_F(CommandRunTest, ValuesAreObservedAndCaptured) {
  RuntimeCommand moved = move(0.3);
  moved.observe("progress", moved.action().progress());
  moved.capture("q at half", expression::measured_joints(cell.cell, "arm"), moved.action().at_path(0.5));
  LoadedCommand handle = load(moved);
  handle.start();
  for (int i = 0; i < 50; ++i) cell.runtime.step();
  EXPECT_GT(handle.value<net::Real>("progress").value_or(0.0), 0.0);
  EXPECT_EQ(handle.value<net::JointArray>("q at half"), std::nullopt);
  EXPECT_TRUE(handle.wait().succeeded());
  EXPECT_NEAR(handle.value<net::JointArray>("q at half")->value[0], cell.arm->home[0] + 0.15, 2e-3);
  EXPECT_EQ(handle.value<net::Real>("nothing"), std::nullopt);
}

}  // namespace
}  // namespace takt::command
