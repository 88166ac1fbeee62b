// A command that is cancelled, aborted or paused at any time.
#include <gtest/gtest.h>

#include "core/command/mapping.h"
#include "tests/core/command/command_cell.h"

namespace takt::command {
namespace {

using test::CommandCell;

enum class How { kCancel, kAbort, kPause };

class Interrupted : public testing::TestWithParam<How> {};

/// A sequence of two motions on one arm with an output in between; the button pauses it.
TransactionCommand example(const CommandCell& cell) {
  const PlanParameters wish{.velocity = 1.0,
                            .clock = {.speed = {}, .pause = expression::digital_input(cell.cell, "button")}};
  const RuntimeCommand out("out", cell.arm_actuator(), ptp(cell.joints(0.08, -0.05), wish));
  const RuntimeCommand mark("mark", cell.driver(), set_value(true));
  const RuntimeCommand back("back", cell.arm_actuator(), ptp(cell.arm->home, wish));
  TransactionCommand example("example");
  example.add_started(out).add(mark).add(back);
  example.on_entered(out.action().at_path(0.5), start(mark)).on_entered(out.completed(), start(back));
  return example;
}

TEST_P(Interrupted, L6_P2_AtEveryTenthCycleNoLimitIsBrokenAndTheArmIsFreeAfterwards) {
  bool ended = false;
  for (int at = 1; !ended; at += 10) {
    CommandCell cell;
    auto handle = cell.runtime.load(example(cell));
    ASSERT_TRUE(handle.has_value()) << handle.error().to_string();
    handle->start();
    for (int i = 0; i < at; ++i) cell.runtime.step();
    ended = handle->status().ended();
    if (GetParam() == How::kCancel) handle->cancel();
    if (GetParam() == How::kAbort) handle->abort();
    cell.button->sample.value = GetParam() == How::kPause;
    for (int i = 0; i < 400; ++i) cell.runtime.step();
    ASSERT_TRUE(cell.core_arm().at_rest()) << "interrupted in cycle " << at;
    cell.button->sample.value = false;
    const CommandStatus status = handle->wait(5000);
    ASSERT_TRUE(status.ended()) << at;
    if (GetParam() != How::kAbort) {
      ASSERT_TRUE(status.succeeded()) << at << status.to_string();
    }
    if (GetParam() == How::kPause) {
      ASSERT_EQ(cell.q(), cell.arm->home) << at;
    }
    const CommandStatus next =
        cell.runtime.execute(RuntimeCommand("next", cell.arm_actuator(), ptp(cell.joints(0.02), {.velocity = 1.0})));
    ASSERT_TRUE(next.succeeded()) << at << ": " << next.to_string();
    ASSERT_LE(cell.worst_limit_share(), 1.0) << at;
  }
}
INSTANTIATE_TEST_SUITE_P(How, Interrupted, testing::Values(How::kCancel, How::kAbort, How::kPause));

}  // namespace
}  // namespace takt::command
