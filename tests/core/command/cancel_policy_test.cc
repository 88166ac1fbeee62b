// What a cancel and a stop reach in a tree (rules C3, C4 of docs/command-layer.md, row L6): policies, clean-up that
// runs to its end, the bound of a cancel, and arms that are stopped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/command/actions/online_action.h"
#include "core/command/check.h"
#include "core/command/mapping.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::command {
namespace {

using activity::RunState;
using takt::test::Reports;

class CancelPolicyTest : public testing::Test {
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
  /// Some two seconds long.
  RuntimeCommand up(const std::string& name = "up") const {
    return {name, cell.arm_actuator(), lin(cell.moved(0, 0.1, 0.02), {.linear_velocity = 0.05})};
  }
  bool lamp() const { return cell.cell.digital_outputs.at("lamp")->value(); }
  bool driver() const { return cell.cell.digital_outputs.at("driver")->value(); }
  std::int64_t cycles(LoadedCommand& handle) { return handle.status().last_cycle - handle.status().first_cycle; }

  test::CommandCell cell;
};

TEST_F(CancelPolicyTest, C4_L6_WhatACancelIsNotForwardedToGoesOnToItsEnd) {
  const RuntimeCommand motion = up();
  const WaitCommand wait("wait", button());
  TransactionCommand both("both");
  both.add_started(motion).add_started(wait).on_cancel_forward_to({wait});
  const Eigen::Isometry3d X_BT = cell.moved(0, 0.1, 0.02);
  LoadedCommand handle = started(both);
  steps(300);
  handle.cancel();
  EXPECT_EQ(handle.wait().state, RunState::kCancelled) << handle.status().to_string();
  EXPECT_GT(cycles(handle), 2000);
  const Eigen::Isometry3d there = cell.arm->chain->forward(cell.q()) * cell.cell.arms.at("arm").X_FT;
  EXPECT_LT((there.translation() - X_BT.translation()).norm(), 1e-6);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(CancelPolicyTest, C4_L6_WhatIgnoresACancelLastsAsLongAsItLasts) {
  const WaitCommand long_one("long", 12.0);
  const RuntimeCommand then = on();
  TransactionCommand both("both");
  both.add_started(long_one).add(then).on_cancel_ignore().on_entered(long_one.completed(), start(then));
  LoadedCommand handle = started(both);
  steps(20);
  handle.cancel();
  EXPECT_EQ(handle.wait(12'100).state, RunState::kCancelled) << handle.status().to_string();
  EXPECT_TRUE(driver());
}

TEST_F(CancelPolicyTest, C4_L6_WhatStillAwaitsItsStartDoesNotCountEither) {
  const WaitCommand first("first", 0.01);
  const RuntimeCommand then = on();
  TransactionCommand both("both");
  both.add_started(first).add(then).on_cancel_ignore().on_entered(button() && first.completed(), start(then));
  LoadedCommand handle = started(both);
  steps(20);
  handle.cancel();
  steps(11'000);
  EXPECT_FALSE(handle.status().ended()) << handle.status().to_string();
  press(true);
  EXPECT_EQ(handle.wait(20).state, RunState::kCancelled);
  EXPECT_TRUE(driver());
}

// The torch after a seam: the gas flows on for a while, then the arm retracts.
TEST_F(CancelPolicyTest, C4_WhatACancelStartsRunsToItsEndAndSoDoesWhatFollows) {
  const RuntimeCommand weld = up("weld"), off = light("off"), never = on("never");
  const WaitCommand post("post", 0.5);
  TransactionCommand seam("seam");
  seam.add_started(weld).add(post).add(off).add(never);
  seam.on_entered(seam.cancelled() && weld.completed(), start(post)).on_entered(post.completed(), start(off));
  seam.on_entered(weld.completed(), start(never));
  LoadedCommand handle = started(seam);
  steps(300);
  handle.cancel();
  steps(400);
  EXPECT_FALSE(handle.status().ended()) << handle.status().to_string();
  EXPECT_FALSE(lamp());
  EXPECT_EQ(handle.wait(600).state, RunState::kCancelled) << handle.status().to_string();
  EXPECT_TRUE(lamp());
  EXPECT_FALSE(driver()) << "what is no clean-up does not start any more";
  EXPECT_GT(cycles(handle), 800);
}

// The same commands after a natural end and after a cancel; a cancel of what began before it is one.
TEST_F(CancelPolicyTest, C4_CleanUpMayAlsoFollowANaturalEnd) {
  enum class When { kNever, kWhileWelding, kWhilePost };
  for (const When when : {When::kNever, When::kWhileWelding, When::kWhilePost}) {
    SCOPED_TRACE(static_cast<int>(when));
    const WaitCommand weld("weld", 0.2), post("post", 0.3), more("more", 0.1);
    test::CommandCell own;
    const RuntimeCommand off("off", own.lamp(), set_value(true));
    TransactionCommand seam("seam");
    seam.add_started(weld).add(post).add(more).add(off);
    seam.on_entered(weld.completed(), start(post));
    seam.on_entered(seam.cancelled() && weld.completed(), start(post));
    seam.on_entered(post.completed(), start(more)).on_entered(more.completed(), start(off));
    auto loaded = own.runtime.load(seam);
    ASSERT_TRUE(loaded) << loaded.error().to_string();
    loaded->start();
    const int before = when == When::kWhileWelding ? 100 : 300;
    for (int i = 0; i < before; ++i) own.runtime.step();
    if (when != When::kNever) loaded->cancel();
    (void)loaded->wait(2000);
    const bool cancelled = when != When::kNever;
    EXPECT_EQ(loaded->status().state, cancelled ? RunState::kCancelled : RunState::kCompleted)
        << loaded->status().to_string();
    EXPECT_EQ(own.cell.digital_outputs.at("lamp")->value(), when != When::kWhilePost);
    const std::int64_t lasted = loaded->status().last_cycle - loaded->status().first_cycle;
    EXPECT_NEAR(static_cast<double>(lasted), when == When::kNever ? 600 : when == When::kWhileWelding ? 500 : 300, 5.0);
  }
}

TEST_F(CancelPolicyTest, C4_ATransactionInsideCleansUpWhenTheCancelComesFromAround) {
  const RuntimeCommand weld = up("weld"), off = light("off");
  const WaitCommand post("post", 0.2), other("other", 30.0);
  TransactionCommand seam("seam"), whole("whole");
  seam.add_started(weld).add(post).add(off);
  seam.on_entered(seam.cancelled() && weld.completed(), start(post)).on_entered(post.completed(), start(off));
  whole.add_started(seam).add_started(other);
  LoadedCommand handle = started(whole);
  steps(300);
  handle.cancel();
  EXPECT_EQ(handle.wait(1500).state, RunState::kCancelled) << handle.status().to_string();
  EXPECT_TRUE(lamp());
}

TEST_F(CancelPolicyTest, C4_ADelayedStartOfTheTransactionsOwnStartIsRevoked) {
  const WaitCommand wait("wait", 5.0);
  const RuntimeCommand later = on();
  TransactionCommand both("both");
  both.add_started(wait).add(later).on_entered(both.started(), start(later), {.delay = 0.2});
  LoadedCommand handle = started(both);
  steps(50);
  handle.cancel();
  EXPECT_EQ(handle.wait(400).state, RunState::kCancelled);
  EXPECT_FALSE(driver());
}

// -- Stop -------------------------------------------------------------------------------------------------------------

TEST_F(CancelPolicyTest, C3_P2_AStoppedMotionComesToRestOnItsPathAndCountsAsCancelled) {
  RuntimeCommand motion = up();
  motion.on_entered(button(), stop(motion));
  const Eigen::Vector3d begin = cell.moved(0, 0, 0).translation();
  const Eigen::Vector3d direction = (cell.moved(0, 0.1, 0.02).translation() - begin).normalized();
  LoadedCommand handle = started(motion);
  steps(600);
  press(true);
  const CommandStatus status = handle.wait(1000);
  EXPECT_EQ(status.state, RunState::kCancelled) << status.to_string();
  EXPECT_EQ(status.cause.code, net::Cause::Code::kCancelled);
  EXPECT_TRUE(cell.core_arm().at_rest());
  const Eigen::Vector3d way = cell.moved(0, 0, 0).translation() - begin;
  EXPECT_GT(way.norm(), 0.01);
  EXPECT_LT(way.norm(), 0.09);
  EXPECT_LT(way.cross(direction).norm(), 1e-5) << "it has not left its line";
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(CancelPolicyTest, C3_WhatFollowsAStopBeginsWhenTheArmRests) {
  const RuntimeCommand motion = up();
  const RuntimeCommand held("held", cell.arm_actuator(), hold()), other = light();
  TransactionCommand both("both");
  both.add_started(motion).add(held).add(other);
  both.on_entered(button(), stop(motion)).on_entered(motion.stopped(), start(held));
  both.on_entered(motion.completed(), start(other)).on_left(button(), cancel(held));
  LoadedCommand handle = started(both);
  steps(600);
  press(true);
  steps(1000);
  EXPECT_FALSE(handle.status().ended()) << handle.status().to_string();
  press(false);
  EXPECT_EQ(handle.wait(100).state, RunState::kCompleted) << handle.status().to_string();
  EXPECT_FALSE(lamp()) << "stopped is not completed";
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(CancelPolicyTest, C3_AStopOfTheWholeWaitsForItsArms) {
  const RuntimeCommand motion = up(), never = light();
  const WaitCommand wait("wait", 30.0);
  TransactionCommand inner("inner"), outer("outer");
  inner.add_started(motion).add_started(wait).add(never).on_entered(motion.completed(), start(never));
  outer.add_started(inner).on_entered(button(), stop(outer));
  LoadedCommand handle = started(outer);
  steps(600);
  press(true);
  EXPECT_EQ(handle.wait(1000).state, RunState::kCancelled) << handle.status().to_string();
  EXPECT_TRUE(cell.core_arm().at_rest());
  EXPECT_FALSE(lamp());
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

// -- The end of the root ----------------------------------------------------------------------------------------------

TEST_F(CancelPolicyTest, TheEndOfTheRootIsToldOutside) {
  for (const bool left : {true, false}) {
    std::vector<ExternalEvent> told;
    const Effect tell = external("over", [&told](const ExternalEvent& event) { told.push_back(event); });
    const WaitCommand work("work", 0.02);
    TransactionCommand whole("whole");
    whole.add_started(work);
    if (left) {
      whole.on_left(whole.active(), tell);
    } else {
      whole.on_entered(!whole.active(), tell);
    }
    LoadedCommand handle = started(whole);
    EXPECT_EQ(handle.wait(100).state, RunState::kCompleted) << handle.status().to_string();
    ASSERT_EQ(told.size(), 1u);
    EXPECT_EQ(told.front().cycle, handle.status().last_cycle);
    EXPECT_EQ(cycles(handle), 21);
  }
}

TEST_F(CancelPolicyTest, C11_NothingInATreeActsOnItsEnd) {
  const WaitCommand work("work", 0.02);
  const RuntimeCommand after = light();
  TransactionCommand whole("whole");
  whole.add_started(work).add(after).on_left(whole.active(), start(after));
  EXPECT_THAT(check(whole), Reports(Code::kNeverFires, "/whole/handlers/0", {"C11", "whole"}));
}

// -- Many commands ----------------------------------------------------------------------------------------------------

/// So many sets of one output in a chain, declared forwards or backwards.
TransactionCommand chain(const test::CommandCell& cell, int count, bool backwards) {
  std::vector<RuntimeCommand> sets;
  for (int i = 0; i < count; ++i) sets.emplace_back(fmt::format("c{}", i), cell.driver(), set_value(i % 2 == 0));
  TransactionCommand whole("whole");
  for (int k = 0; k < count; ++k) {
    const int i = backwards ? count - 1 - k : k;
    const RuntimeCommand& one = sets[static_cast<std::size_t>(i)];
    i == 0 ? whole.add_started(one) : whole.add(one);
    if (i > 0) whole.on_entered(sets[static_cast<std::size_t>(i) - 1].completed(), start(one));
  }
  return whole;
}

TEST_F(CancelPolicyTest, O4_AnyNumberOfCommandsTakeTurnsOnOneDevice) {
  for (const int count : {17, 301}) {
    for (const bool backwards : {false, true}) {
      test::CommandCell own;
      auto loaded = own.runtime.load(chain(own, count, backwards));
      ASSERT_TRUE(loaded) << count << " " << loaded.error().to_string().substr(0, 500);
      loaded->start();
      EXPECT_EQ(loaded->wait(count + 10).state, RunState::kCompleted) << loaded->status().to_string();
      EXPECT_TRUE(own.cell.digital_outputs.at("driver")->value());
      EXPECT_NEAR(static_cast<double>(loaded->status().last_cycle - loaded->status().first_cycle), count, 2.0);
    }
  }
}

/// The net of a chain grows in proportion to it, the conflicts that it watches for included.
TEST_F(CancelPolicyTest, O4_ANetOfAChainGrowsInProportion) {
  const auto size = [&](int count) {
    const auto mapped = map(chain(cell, count, false));
    EXPECT_TRUE(mapped);
    return mapped ? static_cast<double>(mapped->net.primitives.size() + mapped->net.links.size()) : 0.0;
  };
  EXPECT_LT(size(200), 2.1 * size(100));
}

TEST_F(CancelPolicyTest, O4_LinesInAChainAreOneNet) {
  std::vector<RuntimeCommand> lines;
  TransactionCommand whole("whole");
  for (int i = 0; i < 18; ++i) {
    const bool there = i % 2 == 0;
    lines.emplace_back(fmt::format("l{}", i), cell.arm_actuator(),
                       lin(cell.moved(0, there ? 0.01 : 0.0, 0), {.linear_velocity = 0.1}));
    i == 0 ? whole.add_started(lines.back()) : whole.add(lines.back());
    if (i > 0) {
      const expression::State ended = lines[static_cast<std::size_t>(i) - 1].completed();
      whole.on_entered(ended && !lines[static_cast<std::size_t>(i) - 1].cancelled(), start(lines.back()));
    }
  }
  LoadedCommand handle = started(whole);
  EXPECT_EQ(handle.wait(20'000).state, RunState::kCompleted) << handle.status().to_string();
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

}  // namespace
}  // namespace takt::command
