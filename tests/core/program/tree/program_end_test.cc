// A program in C++ that is held, cancelled or broken off as a whole (docs/cpp-api.md).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/activity/activity_cell.h"

namespace takt::program {
namespace {

class ProgramEndTest : public testing::Test {
 protected:
  activity::Activity there() const { return cell.motion.lin_by({0.0, 0.15, 0.0}); }
  void steps(int count) {
    for (int i = 0; i < count; ++i) cell.program.step();
  }
  void expect_free_and_inside_the_limits() {
    EXPECT_TRUE(cell.core_arm().at_rest());
    EXPECT_FALSE(cell.core_arm().held());
    EXPECT_LE(cell.worst_limit_share(), 1.0);
  }
  test::ActivityCell cell;
};

TEST_F(ProgramEndTest, L6_ACancelAtEveryTenthCycleIsHeardWhenAllIsAtRest) {
  const int whole = [] {
    test::ActivityCell own;
    own.motion.lin_by({0.0, 0.15, 0.0}).execute();
    return static_cast<int>(own.core.cycle());
  }();
  for (int at = 0; at < whole - 10; at += 10) {
    SCOPED_TRACE(at);
    test::ActivityCell own;
    const activity::RunPtr run = own.motion.lin_by({0.0, 0.15, 0.0}).schedule();
    const activity::RunPtr waits = own.motion.lin_by({0.0, 0.0, 0.1}).schedule();
    for (int i = 0; i < at; ++i) own.program.step();
    own.program.cancel();
    EXPECT_THROW((void)activity::wait(own.program, waits), activity::ProgramCancelled);
    EXPECT_TRUE(own.program.idle());
    EXPECT_TRUE(own.core_arm().at_rest());
    EXPECT_FALSE(own.core_arm().held());
    EXPECT_TRUE(run->over());
    EXPECT_NE(waits->state(), activity::RunState::kCompleted);
    EXPECT_THROW((void)own.motion.lin_by({0.0, 0.0, 0.1}).schedule(), activity::ProgramCancelled);
    EXPECT_LE(own.worst_limit_share(), 1.0);
  }
}

activity::Task moves(test::ActivityCell& cell, int& ended) {
  const activity::Activity one = cell.motion.lin_by({0.0, 0.15, 0.0}), other = cell.motion.lin_by({0.0, -0.15, 0.0});
  try {
    co_await one;
    co_await other;
  } catch (const activity::ProgramCancelled&) {
    ++ended;
    throw;
  }
}

activity::Task waits(test::ActivityCell& cell, int& ended) {
  try {
    co_await cell.program.cycles(1'000'000);
  } catch (const activity::ProgramCancelled&) {
    ++ended;
    throw;
  }
}

TEST_F(ProgramEndTest, CoroutinesHearOfACancelWhateverTheyWaitFor) {
  int ended = 0;
  cell.program.spawn(waits(cell, ended));
  activity::Task task = moves(cell, ended);
  task.begin();
  steps(100);
  cell.program.cancel();
  EXPECT_THROW(cell.program.run_until([&task] { return task.done(); }), activity::ProgramCancelled);
  EXPECT_EQ(ended, 2);
  expect_free_and_inside_the_limits();
}

TEST_F(ProgramEndTest, CoroutinesWhoseOwnerIsGoneAreForgotten) {
  int ended = 0;
  {
    activity::Task task = moves(cell, ended);
    task.begin();
    steps(100);
    cell.program.drop_coroutines();
  }
  cell.program.cancel();
  while (!cell.program.idle()) cell.program.step();
  EXPECT_EQ(ended, 0);
  expect_free_and_inside_the_limits();
}

TEST_F(ProgramEndTest, NoActivityBeginsWhileItIsHeld) {
  cell.program.hold(true);
  const activity::RunPtr run = there().schedule();
  steps(50);
  EXPECT_EQ(run->state(), activity::RunState::kQueued);
  EXPECT_EQ(cell.program.current(), "");
  cell.program.hold(false);
  steps(10);
  EXPECT_EQ(run->state(), activity::RunState::kRunning);
  EXPECT_EQ(cell.program.current(), "arm LIN");
  activity::wait(cell.program, run);
  EXPECT_EQ(run->state(), activity::RunState::kCompleted);
  EXPECT_GT(run->preparation().total, run->preparation().planning);
  EXPECT_GE(run->first_cycle(), run->asked_cycle() + 50);
}

}  // namespace
}  // namespace takt::program
