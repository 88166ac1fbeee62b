// What follows a command; what must not hold while an activity runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/activity/command_activity.h"
#include "tests/core/activity/activity_cell.h"

namespace takt::activity {
namespace {

class FollowedTest : public testing::Test {
 protected:
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) cell.program.step();
  }
  test::ActivityCell cell;
};

// 2013, 4.4: a command is scheduled after another one; no cycle is lost between them.
TEST_F(FollowedTest, CommandsFollowEachOtherWithoutAnEmptyCycle) {
  const auto line = [&](const char* name, double y) -> command::RuntimeCommand {
    return {name, cell.arm_actuator(), command::lin(cell.moved(0.0, y, 0.0))};
  };
  command::RuntimeCommand there = line("there", 0.05), light("light", cell.lamp(), command::set_value(true));
  command::TransactionCommand first("first");
  first.add_started(there).add(light).on_entered(there.completed(), start(light));
  const RunPtr one = cell.program.schedule(command_activity(first));
  const RunPtr two = cell.program.schedule(command_activity(line("back", 0.0)));
  run(20);
  EXPECT_EQ(one->state(), RunState::kRunning);
  EXPECT_EQ(two->state(), RunState::kLoaded) << "planned from where the first one will end";
  cell.program.run_until([&] { return two->over(); });
  require(one);
  require(two);
  EXPECT_EQ(two->first_cycle(), one->last_cycle() + 1);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(FollowedTest, WhatFollowsACommandThatMayBeCutShortWaitsForItsEnd) {
  command::RuntimeCommand there("there", cell.arm_actuator(), command::lin(cell.moved(0.0, 0.05, 0.0)));
  there.on_entered(cell.hard(), cancel(there));
  const RunPtr one = cell.program.schedule(command_activity(there));
  const RunPtr two = cell.motion.ptp(cell.arm->home).schedule();
  run(20);
  EXPECT_EQ(two->state(), RunState::kQueued);
  cell.program.run_until([&] { return two->over(); });
  require(two);
  EXPECT_LT((cell.robot.q() - cell.arm->home).norm(), 1e-9);
}

// What must not hold ends whatever runs, and fails it.
TEST_F(FollowedTest, AbortIfFailsEveryOperationThatMovesSomething) {
  const auto button = expression::digital_input(cell.cell, "button");
  const Eigen::Vector3d down(0.0, 0.0, -1.0);
  const app::Actuator lamp(cell.program, "lamp");
  const std::vector<Activity> all{
      cell.motion.lin_by({0.0, 0.08, 0.0}),
      cell.motion.ptp(cell.joints(0.3)),
      cell.robot.use<app::HoldInterface>().hold(),
      cell.robot.use<app::ForceInterface>().press({.direction = down, .in = "arm"}),
      sequence({lamp.use<app::OutputInterface>().set(true), cell.motion.lin_by({0.0, 0.0, 0.05})}),
      parallel({cell.motion.lin_by({0.05, 0.0, 0.0}), lamp.use<app::OutputInterface>().set(false)})};
  for (const Activity& one : all) {
    SCOPED_TRACE(one.model()->name());
    cell.button->sample.value = false;
    run(5);
    const RunPtr aborted = abort_if(one, button).begin_execute();
    const RunPtr behind = cell.motion.ptp(cell.arm->home).schedule();
    run(60);
    ASSERT_EQ(aborted->state(), RunState::kRunning);
    cell.button->sample.value = true;
    cell.program.run_until([&] { return aborted->over(); });
    EXPECT_EQ(aborted->state(), RunState::kFailed);
    EXPECT_EQ(aborted->failure(), RunFailure::kAborted);
    EXPECT_EQ(aborted->diagnostics().list().front().code, Code::kAbortCondition);
    EXPECT_EQ(behind->failure(), RunFailure::kGivenUp);
    EXPECT_TRUE(cell.core_arm().at_rest());
    EXPECT_LE(cell.worst_limit_share(), 1.0);
    cell.motion.ptp(cell.arm->home).execute();
  }
}

TEST_F(FollowedTest, AbortIfThatNeverHoldsChangesNothingAndASilentSensorAborts) {
  const auto button = expression::digital_input(cell.cell, "button");
  cell.button->sample.value = false;
  abort_if(cell.motion.lin_by({0.0, 0.03, 0.0}), button).execute();
  const RunPtr silent = abort_if(cell.motion.lin_by({0.0, 0.05, 0.0}), cell.hard()).begin_execute();
  run(20);
  cell.sensor->silent = true;
  cell.program.run_until([&] { return silent->over(); });
  EXPECT_EQ(silent->failure(), RunFailure::kAborted);
  EXPECT_EQ(silent->diagnostics().list().front().code, Code::kSensorSilent);
}

// It holds on what a successor does of the motion, too.
TEST_F(FollowedTest, AbortIfOfAMotionHoldsThroughItsBlend) {
  const Eigen::Isometry3d goal = cell.moved(0.0, 0.1, 0.0), goal2 = cell.moved(-0.1, 0.1, 0.0);
  const auto button = expression::digital_input(cell.cell, "button");
  const RunPtr first =
      cell.motion.lin(goal, {.linear_velocity = 0.1, .blend = 0.7, .abort_if = button}).begin_execute();
  const RunPtr second = cell.motion.lin(goal2, {.linear_velocity = 0.1}).schedule();
  cell.program.run_until([&] { return second->blended(); });
  cell.button->sample.value = true;
  cell.program.run_until([&] { return first->over() && second->over(); });
  EXPECT_EQ(first->failure(), RunFailure::kStopped) << "who carried out its rest has failed";
  EXPECT_EQ(second->failure(), RunFailure::kAborted);
  EXPECT_EQ(second->diagnostics().list().front().pointer, "/arm LIN") << "it was not its own";
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

}  // namespace
}  // namespace takt::activity
