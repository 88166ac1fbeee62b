// Actions that find their set points in the cycle: jogging with a dead-man switch, following, holding a force.
#include "core/command/actions/online_action.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/command/actions/overlay_action.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::command {
namespace {

using takt::test::Reports;

class OnlineTest : public testing::Test {
 protected:
  LoadedCommand begin(const Command& command) {
    auto handle = cell.runtime.load(command);
    if (!handle) ADD_FAILURE() << handle.error().to_string();
    handle->start();
    return handle.value();
  }
  Eigen::Vector3d tool() const { return (cell.X_WB.inverse() * cell.tool_in_world(cell.q())).translation(); }
  void expect_ends_at_rest(LoadedCommand& handle) {
    handle.cancel();
    const CommandStatus status = handle.wait(1000);
    EXPECT_TRUE(status.succeeded()) << status.to_string();
    EXPECT_TRUE(cell.core_arm().at_rest());
    EXPECT_LE(cell.worst_limit_share(), 1.0);
  }
  test::CommandCell cell;
};

class JogTest : public OnlineTest {
 protected:
  JogTest() {
    handle.emplace(
        begin(RuntimeCommand("jog", cell.arm_actuator(),
                             jog(channel<net::Twist>(cell.cell, "stick"),
                                 expression::holds(channel<bool>(cell.cell, "enable")), {.linear_max = 0.05}))));
  }
  void push(double vx, bool enabled, int cycles) {
    for (int i = 0; i < cycles; ++i) {
      cell.cell.channels.at("stick")->write(net::Twist{.linear = {vx, 0, 0}});
      cell.cell.channels.at("enable")->write(enabled);
      cell.runtime.step();
    }
  }
  double speed() const { return cell.core_arm().set_point().dq.norm(); }
  std::optional<LoadedCommand> handle;
};

TEST_F(JogTest, MovesWhileTheSwitchIsHeldAndNoFasterThanAllowed) {
  const Eigen::Vector3d from = tool();
  push(1.0, false, 100);
  EXPECT_EQ(tool(), from) << "not held";
  push(1.0, true, 500);
  const Eigen::Vector3d before = tool();
  push(1.0, true, 1);
  EXPECT_NEAR((tool() - before).x() / 1e-3, 0.05, 1e-4);
  EXPECT_GT((tool() - from).x(), 0.015);
  expect_ends_at_rest(*handle);
}

TEST_F(JogTest, ComesToRestWhenTheSwitchFalls) {
  push(0.05, true, 300);
  ASSERT_GT(speed(), 0.01);
  push(0.05, false, 400);
  EXPECT_TRUE(cell.core_arm().at_rest());
  EXPECT_FALSE(handle->status().ended()) << "it waits for the next push";
  push(-0.05, true, 100);
  EXPECT_GT(speed(), 0.01);
  expect_ends_at_rest(*handle);
}

TEST_F(JogTest, ComesToRestWhenNobodyAnswersAnyMore) {
  push(0.05, true, 300);
  ASSERT_GT(speed(), 0.01);
  for (int i = 0; i < 500; ++i) cell.runtime.step();
  EXPECT_TRUE(cell.core_arm().at_rest()) << "the channels are too old";
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(OnlineTest, APoseIsFollowedAndLostWithoutAJump) {
  RuntimeCommand command("follow", cell.arm_actuator(), follow(channel<net::Frame>(cell.cell, "target")));
  command.observe("arrived", expression::BooleanSensor(command.action().state("arrived").node()));
  command.observe("error", expression::BooleanSensor(command.action().error().node()));
  LoadedCommand handle = begin(command);
  const Eigen::Isometry3d goal = cell.moved(0.03, 0.05, -0.02);
  for (int i = 0; i < 50; ++i) cell.runtime.step();
  EXPECT_EQ(handle.value<bool>("error"), true) << "no target yet";
  cell.cell.channels.at("target")->write(net::Frame(goal));
  for (int i = 0; i < 4000; ++i) cell.runtime.step();
  EXPECT_EQ(handle.value<bool>("error"), false);
  EXPECT_EQ(handle.value<bool>("arrived"), true);
  EXPECT_LT((tool() - goal.translation()).norm(), 1e-4);
  cell.cell.channels.at("target")->write(net::Frame(cell.moved(-0.2, 0, 0)));
  for (int i = 0; i < 300; ++i) cell.runtime.step();
  expect_ends_at_rest(handle);
}

TEST_F(OnlineTest, JointsGoToATargetThatChanges) {
  RuntimeCommand command("follow", cell.arm_actuator(),
                         follow(channel<net::JointArray>(cell.cell, "posture"), 0.5, 0.5));
  LoadedCommand handle = begin(command);
  for (int i = 0; i < 20; ++i) cell.runtime.step();
  EXPECT_EQ(cell.q(), cell.arm->home);
  cell.cell.channels.at("posture")->write(net::JointArray(cell.joints(0.4)));
  for (int i = 0; i < 300; ++i) cell.runtime.step();
  cell.cell.channels.at("posture")->write(net::JointArray(cell.joints(-0.1, 0.1)));
  for (int i = 0; i < 4000; ++i) cell.runtime.step();
  EXPECT_LT((cell.q() - cell.joints(-0.1, 0.1)).norm(), 1e-9);
  cell.cell.channels.at("posture")->write(net::JointArray(cell.joints(0.5)));
  for (int i = 0; i < 300; ++i) cell.runtime.step();
  expect_ends_at_rest(handle);
}

TEST_F(OnlineTest, AWeaveSwingsBesideThePathAndStandsWithIt) {
  const Eigen::Vector3d from = tool();
  const WeaveParameters wish{.amplitude = 0.003, .frequency = 2.0, .direction_M = Eigen::Vector3d::UnitX()};
  RuntimeCommand seam("seam", cell.arm_actuator(), weave(lin(cell.moved(0, 0.1, 0), {.linear_velocity = 0.03}), wish));
  const Eigen::Vector3d across =
      (cell.arm->chain->forward(cell.q()) * cell.cell.arms.at("arm").X_FT).linear() * wish.direction_M;
  LoadedCommand handle = begin(seam);
  double least = 0.0, most = 0.0;
  for (int i = 0; i < 10'000 && !handle.status().ended(); ++i) {
    cell.runtime.step();
    const double side = across.dot(tool() - from - Eigen::Vector3d(0, tool().y() - from.y(), 0));
    least = std::min(least, side);
    most = std::max(most, side);
  }
  EXPECT_TRUE(handle.status().succeeded()) << handle.status().to_string();
  EXPECT_NEAR(most, 0.003, 3e-4);
  EXPECT_NEAR(least, -0.003, 3e-4);
  EXPECT_LT((tool() - from - Eigen::Vector3d(0, 0.1, 0)).norm(), 1e-9) << "it fades to the goal";
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(OnlineTest, AWeaveThatIsTooFastOrHasNoFrameIsRefused) {
  RuntimeCommand fast("fast", cell.arm_actuator(),
                      weave(lin(cell.moved(0, 0.1, 0)), {.amplitude = 0.01, .frequency = 10.0}));
  EXPECT_THAT(cell.runtime.load(fast).error(), Reports(Code::kOutOfRange, "/fast"));
  RuntimeCommand joints("joints", cell.arm_actuator(), weave(ptp(cell.joints(0.1))));
  EXPECT_THAT(cell.runtime.load(joints).error(), Reports(Code::kConflict, "/joints", {"C8"}));
}

/// The ramp that a refusal suggests, s.
double shortest_ramp(const Diagnostics& refusal) { return takt::test::first_number(refusal.list().front().hint); }

// What a weave needs most it needs in its ramps: those that the check lets pass are within all limits, in any phase.
TEST_F(OnlineTest, AWeaveIsCheckedWithItsRampsAndTheShortestOneRuns) {
  for (const double frequency : {0.5, 1.0, 2.0, 2.5}) {
    for (const double amplitude : {0.001, 0.003}) {
      SCOPED_TRACE(testing::Message() << amplitude << " m at " << frequency << " Hz");
      const auto seam = [&](double ramp) {
        const WeaveParameters wish{.amplitude = amplitude, .frequency = frequency, .ramp = ramp};
        return RuntimeCommand("seam", cell.arm_actuator(),
                              weave(lin(cell.moved(0, 0.04, 0), {.acceleration = 0.8, .linear_velocity = 0.03}), wish));
      };
      const auto refused = cell.runtime.load(seam(0.01));
      ASSERT_FALSE(refused) << "of a hundredth of a second";
      const double shortest = shortest_ramp(refused.error());
      ASSERT_GT(shortest, 0.01) << refused.error().to_string();
      ASSERT_LT(shortest, 0.5);
      const auto shorter = cell.runtime.load(seam(0.95 * shortest));
      EXPECT_FALSE(shorter) << "just outside";
      EXPECT_NEAR(shorter ? 0.0 : shortest_ramp(shorter.error()), shortest, 0.03 * shortest);
      const Eigen::Vector3d goal = cell.moved(0, 0.04, 0).translation();
      LoadedCommand handle = begin(seam(shortest));
      EXPECT_TRUE(cell.run(handle).succeeded()) << handle.status().to_string();
      EXPECT_LT((cell.moved(0, 0, 0).translation() - goal).norm(), 1e-6);
    }
  }
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(OnlineTest, ARampOfManyPeriodsCostsNothing) {
  // At the limit of what is left of the acceleration, but for 1 %.
  const double omega = 2.0 * std::numbers::pi * 4.0;
  const double most = 0.2 * cell.arm->cartesian.linear_acceleration / (omega * omega);
  const auto seam = [&](double share, double ramp) {
    return RuntimeCommand("seam", cell.arm_actuator(),
                          weave(lin(cell.moved(0, 0.2, 0), {.linear_velocity = 0.01}),
                                {.amplitude = share * most, .frequency = 4.0, .ramp = ramp}));
  };
  EXPECT_TRUE(cell.runtime.load(seam(0.99, 8.0)));
  EXPECT_FALSE(cell.runtime.load(seam(1.01, 8.0)));
  EXPECT_FALSE(cell.runtime.load(seam(0.99, 0.02)));
}

TEST_F(OnlineTest, AForceIsBroughtUpAndHeld) {
  // The block stands below the tool, stiff as steel; here it gives way like a spring that controllers can hold.
  const Eigen::Vector3d down(0, 0, -1);
  RuntimeCommand press(
      "press", cell.arm_actuator(),
      hold_force(pressing_force(cell.cell, "wrist", down, {{"wrist", cell.bias}}), Eigen::Isometry3d::Identity(), down,
                 {.force = 8.0, .approach_velocity = 0.02, .gain = 1e-3}));
  press.observe("pressing", pressing_force(cell.cell, "wrist", down, {{"wrist", cell.bias}}));
  press.observe("contact", expression::BooleanSensor(press.action().state("in_contact").node()));
  LoadedCommand handle = begin(press);
  const double ground = tool().z() - 0.01;  // m
  const auto spring = [&] {
    const double depth = std::max(0.0, ground - tool().z());
    const auto X_WS = cell.X_WB * cell.arm->chain->forward(cell.q()) * cell.cell.sensors.at("wrist").X_FS;
    cell.extra.force = X_WS.linear().transpose() * Eigen::Vector3d(0, 0, 5000.0 * depth);
    cell.runtime.step();
  };
  for (int i = 0; i < 300; ++i) spring();
  EXPECT_EQ(handle.value<bool>("contact"), false) << "on its way";
  for (int i = 0; i < 5000; ++i) spring();
  EXPECT_EQ(handle.value<bool>("contact"), true);
  EXPECT_NEAR(handle.value<net::Real>("pressing").value_or(0.0), 8.0, 0.1);
  expect_ends_at_rest(handle);
}

}  // namespace
}  // namespace takt::command
