// Single joints are jogged while a dead-man switch is held.
#include "core/command/actions/joint_jog_action.h"

#include <gtest/gtest.h>

#include "tests/core/command/command_cell.h"

namespace takt::command {
namespace {

/// Rates that never change: joint 1 at 0.2 rad/s.
expression::JointsSensor constant_rates(Eigen::Index joints) {
  kinematics::JointVector rates = kinematics::JointVector::Zero(joints);
  rates[1] = 0.2;
  return expression::JointsSensor(
      expression::apply(net::ValueType::kJoints, "ConstantJoints",
                        {{"value", expression::Term<net::JointArray>(net::JointArray(rates)).operand()}}));
}

class JointJogTest : public testing::Test {
 protected:
  Command command(const TrackingParameters& bounds = {.linear_max = 1.0, .angular_max = 2.0}) {
    return RuntimeCommand("jog", cell.arm_actuator(),
                          jog(constant_rates(cell.core_arm().set_point().q.size()),
                              expression::holds(channel<bool>(cell.cell, "enable")), bounds));
  }
  void hold(bool enabled, int cycles) {
    for (int i = 0; i < cycles; ++i) {
      cell.cell.channels.at("enable")->write(enabled);
      cell.runtime.step();
    }
  }
  test::CommandCell cell;
};

TEST_F(JointJogTest, OneJointMovesWhileTheSwitchIsHeld) {
  auto handle = cell.runtime.load(command());
  ASSERT_TRUE(handle) << handle.error().to_string();
  handle->start();
  const kinematics::JointVector from = cell.core_arm().set_point().q;
  hold(false, 100);
  EXPECT_EQ(cell.core_arm().set_point().q, from);
  hold(true, 500);
  kinematics::JointVector way = cell.core_arm().set_point().q - from;
  EXPECT_NEAR(way[1], 0.1, 0.03);
  EXPECT_NEAR(cell.core_arm().set_point().dq[1], 0.2, 1e-6);
  way[1] = 0.0;
  EXPECT_LT(way.norm(), 1e-9);
  hold(false, 400);
  EXPECT_TRUE(cell.core_arm().at_rest()) << "the switch fell";
  EXPECT_FALSE(handle->status().ended());
  hold(true, 100);
  handle->cancel();
  const CommandStatus status = handle->wait(1000);
  EXPECT_TRUE(status.succeeded()) << status.to_string();
  EXPECT_TRUE(cell.core_arm().at_rest());
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(JointJogTest, BoundsOfTheToolSlowTheJoints) {
  auto handle = cell.runtime.load(command({.linear_max = 0.02, .angular_max = 2.0}));
  ASSERT_TRUE(handle) << handle.error().to_string();
  handle->start();
  hold(true, 500);
  EXPECT_GT(cell.core_arm().set_point().dq[1], 0.0);
  EXPECT_LT(cell.core_arm().set_point().dq[1], 0.1);
}

TEST_F(JointJogTest, BoundsAreAboveZero) {
  const auto refused = cell.runtime.load(command({.linear_max = 0.0, .angular_max = -1.0}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().list().size(), 2u);
  for (const Diagnostic& one : refused.error().list()) EXPECT_EQ(one.code, Code::kOutOfRange);
}

}  // namespace
}  // namespace takt::command
