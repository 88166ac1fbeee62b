// Row P2: whatever moves an arm hears Actuator::pause() and the override, of either arm of a pair too; commands show
// it.
#include <gtest/gtest.h>

#include "app/interfaces/two_arms.h"
#include "core/activity/command_activity.h"
#include "core/command/actions/online_action.h"
#include "tests/core/activity/activity_cell.h"
#include "tests/core/activity/two_arm_cell.h"

namespace takt::activity {
namespace {

using command::RuntimeCommand;

class PauseTest : public testing::Test {
 protected:
  static constexpr double kFar = 0.2;  ///< m

  Activity of_command(const command::Action& action) {
    return {cell.program, command_activity(RuntimeCommand("moves", cell.arm_actuator(), action))};
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) {
      (void)cell.cell.channels.at("target")->write(net::Frame(target));
      (void)cell.cell.channels.at("posture")->write(net::JointArray(posture));
      cell.program.step();
    }
  }
  double path_of(int cycles) {
    const device::JointVector before = cell.q();
    double length = 0.0;
    for (int i = 0; i < cycles; ++i) {
      const device::JointVector last = cell.q();
      steps(1);
      length += (cell.q() - last).norm();
    }
    return std::max(length, (cell.q() - before).norm());
  }
  /// It moves, stands while it is paused, and moves again.
  void expect_heard(const Activity& activity) {
    const RunPtr run = activity.schedule();
    steps(150);
    ASSERT_TRUE(run->started());
    EXPECT_GT(path_of(50), 1e-5) << "it moves";
    cell.robot.pause();
    steps(400);
    ASSERT_FALSE(run->over()) << run->diagnostics().to_string();
    EXPECT_LT(path_of(300), 1e-12) << "it stands in the pause";
    cell.robot.resume();
    steps(150);
    EXPECT_GT(path_of(50), 1e-5) << "it goes on";
    run->cancel();
    for (int i = 0; i < 2'000 && !run->over(); ++i) steps(1);
    EXPECT_EQ(run->state(), RunState::kCancelled) << run->diagnostics().to_string();
    EXPECT_LE(cell.worst_limit_share(), 1.0);
  }
  expression::State always() { return !is_null(expression::channel<net::Real>(cell.cell, "speed")); }

  test::ActivityCell cell;
  Eigen::Isometry3d target = cell.moved(0.0, kFar, 0.0);
  device::JointVector posture = cell.joints(0.8, 0.3);
};

TEST_F(PauseTest, P2_MotionsOfCommands) { expect_heard(of_command(command::lin(target, {.velocity = 0.2}))); }

TEST_F(PauseTest, P2_APressOnItsApproach) {
  expect_heard(cell.robot.use<app::ForceInterface>().press({.approach = 0.02, .travel = 0.05}));
}

TEST_F(PauseTest, P2_AHeldForceOnItsApproach) {
  const Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  const auto pressing = command::pressing_force(cell.cell, "wrist", down, {{"wrist", cell.bias}});
  expect_heard(of_command(command::hold_force(pressing, Eigen::Isometry3d::Identity(), down,
                                              {.force = 10.0, .approach_velocity = 0.02, .gain = 1e-3})));
}

TEST_F(PauseTest, P2_Jog) {
  expect_heard(
      cell.robot.use<app::JogInterface>().jog({.enabled = always(), .linear = Eigen::Vector3d(0.0, 0.05, 0.0)}));
}

TEST_F(PauseTest, P2_AFollowedPose) {
  target = cell.X_WB * cell.moved(0.0, kFar, 0.0);
  expect_heard(cell.robot.use<app::FollowInterface>().follow({.channel = "target", .in = "world", .linear_max = 0.05}));
}

TEST_F(PauseTest, P2_FollowedJoints) {
  expect_heard(of_command(command::follow(expression::channel<net::JointArray>(cell.cell, "posture"), 0.2, 0.5)));
}

TEST_F(PauseTest, P2_AnOverrideSlowsCommandsDown) {
  const auto cycles = [this](double speed) {
    cell.robot.set_speed(speed);
    const auto run = of_command(command::ptp(cell.joints(cell.q()[0] < 0.1 ? 0.4 : 0.0))).execute();
    return static_cast<double>(run->last_cycle() - run->first_cycle());
  };
  const double full = cycles(1.0);
  EXPECT_NEAR(cycles(0.25) / full, 4.0, 0.5);
}

/// A torch goes out when the seam is paused, and its command says so.
TEST_F(PauseTest, P2_ACommandIsPausedAndHandlersReactToIt) {
  RuntimeCommand seam("seam", cell.arm_actuator(), command::lin(target, {.velocity = 0.2}));
  RuntimeCommand torch_off("torch off", cell.driver(), command::set_value(false));
  RuntimeCommand torch_on("torch on", cell.driver(), command::set_value(true));
  command::TransactionCommand weld("weld");
  weld.add_started(seam).add_started(torch_on).add(torch_off);
  weld.on_entered(seam.paused(), start(torch_off));
  weld.observe("paused", expression::BooleanSensor(weld.paused().node()));
  weld.capture("share at the pause", seam.action().progress(), seam.paused());
  const RunPtr run = Activity(cell.program, command_activity(weld)).schedule();
  steps(200);
  EXPECT_FALSE(run->was_true("paused"));
  EXPECT_TRUE(cell.driver_terminal->written.back());
  cell.robot.pause();
  steps(2);
  EXPECT_TRUE(run->was_true("paused")) << "from the cycle on in which people want it";
  steps(3);
  EXPECT_FALSE(cell.driver_terminal->written.back()) << "the torch is out before the arm stands";
  EXPECT_FALSE(cell.core_arm().at_rest());
  steps(500);
  EXPECT_TRUE(cell.core_arm().at_rest());
  cell.robot.resume();
  steps(2);
  EXPECT_FALSE(run->was_true("paused"));
  wait(cell.program, run);
  EXPECT_LT(run->value<net::Real>("share at the pause").value_or(1.0), 0.9);
}

TEST_F(PauseTest, WhatMovesNoArmIsNeverPaused) {
  RuntimeCommand torch("torch", cell.driver(), command::set_value(true));
  torch.observe("paused", expression::BooleanSensor(torch.paused().node()));
  EXPECT_THROW(Activity(cell.program, command_activity(torch)).execute(), ActivityError);
}

/// Two arms on one clock stop for either of them.
TEST(PauseOfTwoArms, P2_ThePairHearsItsFollowerToo) {
  test::TwoArmCell cell;
  const app::TwoArms both = cell.pair();
  const RunPtr run = both.lin_by({0.0, 0.12, 0.05}).schedule();
  for (int i = 0; i < 200; ++i) cell.program.step();
  cell.program.pause("right");
  for (int i = 0; i < 700; ++i) cell.program.step();
  EXPECT_FALSE(run->over());
  for (const char* name : {"left", "right"}) EXPECT_TRUE(cell.core.find_arm(name)->at_rest()) << name;
  cell.program.resume("right");
  wait(cell.program, run);
  EXPECT_EQ(run->state(), RunState::kCompleted);
}

}  // namespace
}  // namespace takt::activity
