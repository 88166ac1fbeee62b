// When a transaction is over (row L9): what waits for a sensor keeps it alive, what cannot come any more does not; the
// end of its last command is an event too; handlers that can never act are refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/command/check.h"
#include "core/command/mapping.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::command {
namespace {

using takt::test::Notes;
using takt::test::Reports;

class TransactionEndTest : public testing::Test {
 protected:
  LoadedCommand started(const Command& command) {
    auto handle = cell.runtime.load(command);
    if (!handle) ADD_FAILURE() << handle.error().to_string();
    handle->start();
    return handle.value();
  }
  void steps(int cycles) {
    for (int i = 0; i < cycles; ++i) cell.runtime.step();
  }
  void press(bool down) { cell.button->sample.value = down; }
  expression::State button() const { return expression::digital_input(cell.cell, "button"); }
  RuntimeCommand on(const std::string& name = "on") const { return {name, cell.driver(), set_value(true)}; }
  RuntimeCommand light(const std::string& name = "light") const { return {name, cell.lamp(), set_value(true)}; }
  bool lamp() const { return cell.cell.digital_outputs.at("lamp")->value(); }
  bool driver() const { return cell.cell.digital_outputs.at("driver")->value(); }

  test::CommandCell cell;
};

// 2010, Listing 1: gas, after its preflow the arc, and "as soon as the arc has been established" the seam.
TEST_F(TransactionEndTest, L9_TheSeamWaitsForItsArc) {
  RuntimeCommand ignition("ignition", cell.arm_actuator(), ptp(cell.joints(0.1))),
      seam("seam", cell.arm_actuator(), ptp(cell.joints(0.2)));
  const RuntimeCommand gas = on("gas"), arc = light("arc");
  TransactionCommand weld("weld");
  weld.add_started(ignition).add(gas).add(arc).add(seam);
  weld.on_entered(ignition.completed(), start(gas)).on_entered(ignition.completed(), start(arc), {.delay = 0.05});
  weld.on_entered(button() && ignition.completed(), start(seam));
  LoadedCommand handle = started(weld);
  steps(3000);
  EXPECT_TRUE(driver());
  EXPECT_TRUE(lamp());
  EXPECT_FALSE(handle.status().ended()) << "the arc does not burn yet: " << handle.status().to_string();
  EXPECT_LT((cell.q() - cell.joints(0.1)).norm(), 1e-9);
  press(true);
  EXPECT_TRUE(handle.wait(3000).succeeded()) << handle.status().to_string();
  EXPECT_LT((cell.q() - cell.joints(0.2)).norm(), 1e-9);
}

TEST_F(TransactionEndTest, L9_ACancelCallsOffWhatWaits) {
  const RuntimeCommand first = on(), second = light();
  TransactionCommand both("both");
  both.add_started(first).add(second).on_entered(button(), start(second));
  LoadedCommand handle = started(both);
  steps(50);
  EXPECT_FALSE(handle.status().ended());
  handle.cancel();
  EXPECT_EQ(handle.wait(20).state, activity::RunState::kCancelled);
  EXPECT_FALSE(lamp());
}

TEST_F(TransactionEndTest, L9_WhatCountsOnlyMeanwhileIsNotWaitedFor) {
  const WaitCommand work("work", 0.05);
  const RuntimeCommand alarm = light();
  TransactionCommand both("both");
  both.add_started(work).add(alarm).on_entered(button() && work.active(), start(alarm));
  LoadedCommand handle = started(both);
  EXPECT_TRUE(handle.wait(200).succeeded());
  EXPECT_EQ(handle.status().last_cycle - handle.status().first_cycle, 50);
}

TEST_F(TransactionEndTest, L9_ARaisedStateMayStillComeFromASensor) {
  const RuntimeCommand first = on(), second = light();
  TransactionCommand both("both");
  const RaisedState go = both.raised("go"), never = both.raised("never");
  both.add_started(first).add(second);
  both.on_entered(button(), raise(go)).on_entered(never.state(), raise(never));
  both.on_entered(go.state() || never.state(), start(second));
  LoadedCommand handle = started(both);
  steps(50);
  EXPECT_FALSE(handle.status().ended());
  press(true);
  EXPECT_TRUE(handle.wait(20).succeeded());
  EXPECT_TRUE(lamp());
}

TEST_F(TransactionEndTest, L9_WhatCannotComeAnyMoreIsNotWaitedFor) {
  const WaitCommand arc("arc", button(), 0.05);
  const RuntimeCommand weld = on(), alarm = light();
  TransactionCommand both("both");
  const RaisedState broken = both.raised("broken");
  both.add_started(arc).add(weld).add(alarm);
  both.on_entered(arc.timed_out(), raise(broken)).on_entered(broken.state() && button(), start(alarm));
  both.on_entered(arc.completed() && !arc.cancelled(), start(weld));
  LoadedCommand handle = started(both);
  steps(20);
  press(true);
  EXPECT_TRUE(handle.wait(20).succeeded()) << "the arc burns, so it is never broken";
  EXPECT_TRUE(driver());
  EXPECT_FALSE(lamp());
}

TEST_F(TransactionEndTest, L9_WhatIsAroundWaitsForWhatIsInside) {
  const RuntimeCommand first = on(), second = light();
  const WaitCommand then("then", 0.01);
  TransactionCommand inner("inner"), outer("outer");
  inner.add_started(first).add(second).on_left(button(), start(second));
  outer.add_started(inner).add(then).on_entered(inner.completed(), start(then));
  LoadedCommand handle = started(outer);
  steps(50);
  EXPECT_FALSE(handle.status().ended()) << "a state that has not held yet may still be left";
  press(true);
  steps(50);
  EXPECT_FALSE(handle.status().ended());
  press(false);
  EXPECT_TRUE(handle.wait(50).succeeded());
  EXPECT_TRUE(lamp());
}

TEST_F(TransactionEndTest, TheEndOfTheLastCommandIsAnEvent) {
  for (const bool on_itself : {false, true}) {
    SCOPED_TRACE(on_itself);
    std::vector<ExternalEvent> told;
    const Effect tell = external("left", [&told](const ExternalEvent& event) { told.push_back(event); });
    WaitCommand work("work", 0.02);
    TransactionCommand one("one");
    if (on_itself) work.on_left(work.active(), tell);
    one.add_started(work);
    if (!on_itself) one.on_entered(!work.active(), tell);
    LoadedCommand handle = started(one);
    EXPECT_TRUE(handle.wait(100).succeeded());
    steps(2);
    ASSERT_EQ(told.size(), 1u);
    EXPECT_EQ(told.front().cycle, handle.status().last_cycle);
    EXPECT_EQ(handle.status().last_cycle - handle.status().first_cycle, 21);
  }
}

TEST_F(TransactionEndTest, WhatTheEndOfTheLastCommandStartsRuns) {
  const WaitCommand work("work", 0.02);
  const RuntimeCommand after = light();
  TransactionCommand both("both");
  both.add_started(work).add(after).on_left(work.active(), start(after));
  LoadedCommand handle = started(both);
  EXPECT_TRUE(handle.wait(100).succeeded());
  EXPECT_TRUE(lamp());
}

TEST_F(TransactionEndTest, C11_AStateThatStaysIsNeverLeft) {
  const RuntimeCommand first = on(), second = light();
  TransactionCommand both("both");
  const RaisedState done = both.raised("done");
  both.add_started(first).add(second);
  both.on_entered(first.completed(), raise(done)).on_left(first.completed() && done.state(), start(second));
  EXPECT_THAT(check(both), Reports(Code::kNeverFires, "/both/handlers/1", {"C11"}));
  EXPECT_FALSE(map(both).has_value());

  const RuntimeCommand third = on(), fourth = light();
  TransactionCommand other("other");
  other.add_started(third).add(fourth).on_left(!third.completed(), start(fourth));
  EXPECT_TRUE(check(other).empty()) << check(other).to_string();
}

TEST_F(TransactionEndTest, C11_AHandlerThatHasEndedBeforeIsRefused) {
  RuntimeCommand first = on();
  const RuntimeCommand second = light();
  first.on_entered(second.completed(), cancel(first));
  TransactionCommand both("both");
  both.add_started(first).add(second).on_entered(first.completed(), start(second));
  EXPECT_THAT(check(both), Reports(Code::kNeverFires, "/both/on/handlers/0", {"C11", "light"}));
}

TEST_F(TransactionEndTest, L9_WhatATransactionWaitsForIsANote) {
  const RuntimeCommand first = on(), second = light();
  TransactionCommand both("both"), meanwhile("meanwhile");
  both.add_started(first).add(second).on_entered(button() && first.completed(), start(second));
  EXPECT_THAT(check(both), Notes("/both/handlers/0", {"light"}));
  EXPECT_FALSE(check(both).has_errors());

  const RuntimeCommand third = on(), fourth = light();
  meanwhile.add_started(third).add(fourth).on_entered(button() && third.active(), start(fourth));
  EXPECT_EQ(check(meanwhile).to_string(), "");
}

}  // namespace
}  // namespace takt::command
