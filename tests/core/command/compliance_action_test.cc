// Impedance as a kind of set point: whatever an arm does, it can be told how to give way meanwhile.
#include "core/command/actions/compliance_action.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/command/actions/online_action.h"
#include "core/command/actions/overlay_action.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::command {
namespace {

using device::ControlMode;
using takt::test::Reports;
using testing::AllOf;

net::JointArray joints(double value) {
  return net::JointArray(device::JointVector(device::JointVector::Constant(7, value)));
}

class ComplianceTest : public testing::Test {
 protected:
  /// Somebody has brought the arm into a mode, as an LWR has it: outside of nets.
  void enter(ControlMode mode) {
    cell.core.change_mode("arm", mode);
    for (int i = 0; i < 600; ++i) cell.runtime.step();
    ASSERT_EQ(cell.core_arm().mode(), mode);
  }
  LoadedCommand begin(const Command& command) {
    auto handle = cell.runtime.load(command);
    if (!handle) ADD_FAILURE() << handle.error().to_string();
    handle->start();
    return handle.value();
  }
  Diagnostics refusal(const Command& command) {
    const auto handle = cell.runtime.load(command);
    return handle ? Diagnostics() : handle.error();
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cell.runtime.step();
  }
  const device::Compliance& given() const { return cell.backend->given.back(); }

  test::CommandCell cell;
};

TEST_F(ComplianceTest, AMotionIsSoftOnItsWayAndSettlesBeforeItsEnd) {
  enter(ControlMode::kJointImpedance);
  RuntimeCommand soft("soft", cell.arm_actuator(),
                      with_compliance(lin(cell.moved(0, 0.1, 0), {.linear_velocity = 0.05}),
                                      JointCompliance{.stiffness = joints(200.0), .damping_ratio = joints(0.9)}));
  soft.observe("settled", expression::BooleanSensor(soft.action().state("settled").node()));
  const Eigen::Isometry3d goal = cell.moved(0, 0.1, 0);
  LoadedCommand handle = begin(soft);
  cycles(20);
  EXPECT_EQ(handle.value<bool>("settled"), false) << "from 1000 to 200 Nm/rad at the device's rate";
  EXPECT_GT(given().stiffness[0], 900.0);
  cycles(400);
  EXPECT_EQ(handle.value<bool>("settled"), true);
  EXPECT_EQ(given().stiffness, (device::JointVector::Constant(7, 200.0)));
  EXPECT_EQ(given().damping_ratio, (device::JointVector::Constant(7, 0.9)));
  EXPECT_TRUE(cell.run(handle).succeeded());
  EXPECT_LT((cell.moved(0, 0, 0).translation() - goal.translation()).norm(), 1e-6);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ComplianceTest, EveryKindOfSetPointTakesIt) {
  enter(ControlMode::kCartesianImpedance);
  const CartesianCompliance soft{.stiffness = net::Vector(500, 600, 700), .nullspace_stiffness = 10.0};
  const auto run = [&](const Action& action) {
    RuntimeCommand command(std::string(action.model().name()), cell.arm_actuator(), with_compliance(action, soft));
    LoadedCommand handle = begin(command);
    cycles(700);
    EXPECT_EQ(given().stiffness.head(3), Eigen::Vector3d(500, 600, 700)) << command.name();
    EXPECT_EQ(given().nullspace_stiffness, 10.0);
    handle.cancel();
    EXPECT_TRUE(handle.wait(4000).succeeded()) << command.name() << ": " << handle.status().to_string();
    EXPECT_EQ(cell.core_arm().mode(), ControlMode::kCartesianImpedance);
  };
  run(ptp(cell.joints(0.3), {.velocity = 0.1}));                // joints
  run(lin(cell.moved(0, 0.05, 0), {.linear_velocity = 0.02}));  // pose
  run(sequence({{.geometry = [&](const auto& q) {
    return motion::ptp_leg(expression::planning_model(cell.cell.arms.at("arm")), q,
                           q + device::JointVector::Constant(7, 0.02));
  }}}));  // path
  run(hold());
  run(follow(channel<net::JointArray>(cell.cell, "posture")));
  run(jog(channel<net::Twist>(cell.cell, "stick"), expression::holds(channel<bool>(cell.cell, "enable"))));  // twist
  run(weave(lin(cell.moved(0, 0.05, 0), {.linear_velocity = 0.02})));
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ComplianceTest, AnOverlayMayLieOverACompliantMotionToo) {
  enter(ControlMode::kJointImpedance);
  RuntimeCommand soft("soft", cell.arm_actuator(),
                      weave(with_compliance(lin(cell.moved(0, 0.05, 0), {.linear_velocity = 0.02}),
                                            JointCompliance{.stiffness = joints(300.0)})));
  LoadedCommand handle = begin(soft);
  cycles(700);
  EXPECT_EQ(given().stiffness[6], 300.0);
  EXPECT_TRUE(cell.run(handle).succeeded());
}

TEST_F(ComplianceTest, ACompliantSequenceTellsItsPointsAndItsPath) {
  enter(ControlMode::kJointImpedance);
  const auto to = [&](double a1, double blend) {
    const auto leg = [this, goal = cell.joints(a1)](const device::JointVector& q) {
      return motion::ptp_leg(expression::planning_model(cell.cell.arms.at("arm")), q, goal);
    };
    return SequencePart{.geometry = leg, .parameters = {}, .blend = {motion::Blend::Kind::kFraction, blend}};
  };
  SequencePart last = to(0.0, 0.0);
  last.blend = {};
  RuntimeCommand soft("soft", cell.arm_actuator(),
                      with_compliance(sequence({to(0.1, 0.3), last}), JointCompliance{.stiffness = joints(300.0)}));
  soft.observe("passed", expression::BooleanSensor(soft.action().via_passed(0).node()));
  LoadedCommand handle = begin(soft);
  EXPECT_NE(soft.node()->model().planned_path().motion, nullptr);
  EXPECT_EQ(soft.node()->model().via_count(), 1);
  cycles(20);
  EXPECT_EQ(handle.value<bool>("passed"), false);
  while (!handle.status().ended() && handle.value<bool>("passed") == false) cycles(1);
  EXPECT_EQ(handle.value<bool>("passed"), true);
  EXPECT_TRUE(cell.run(handle).succeeded());
}

TEST_F(ComplianceTest, ValuesMayBeFormulas) {
  enter(ControlMode::kCartesianImpedance);
  cell.cell.channels.at("speed")->write(0.25);
  const expression::RealSensor share = channel<net::Real>(cell.cell, "speed");
  RuntimeCommand held(
      "hold", cell.arm_actuator(),
      with_compliance(hold(), CartesianCompliance{.damping_ratio = expression::min(expression::max(share, 0.1), 1.0),
                                                  .nullspace_stiffness = 40.0 * share}));
  LoadedCommand handle = begin(held);
  cycles(700);
  EXPECT_NEAR(given().damping_ratio[0], 0.25, 1e-12);
  EXPECT_NEAR(given().nullspace_stiffness, 10.0, 1e-12);
  cell.cell.channels.at("speed")->write(0.5);
  cycles(700);
  EXPECT_NEAR(given().nullspace_stiffness, 20.0, 1e-12);
  EXPECT_FALSE(handle.status().ended());
  cell.cell.channels.at("speed")->write_null();
  cycles(5);
  ASSERT_TRUE(handle.status().ended()) << "nobody knows how soft (row N4)";
  EXPECT_FALSE(handle.status().succeeded());
}

TEST_F(ComplianceTest, AWrenchInTheToolsAxesFadesWhenItIsCancelled) {
  enter(ControlMode::kCartesianImpedance);
  RuntimeCommand held(
      "hold", cell.arm_actuator(),
      with_compliance(hold(), CartesianCompliance{.wrench = net::Wrench{.force = {0, 0, 15}}, .in_tool_axes = true}));
  LoadedCommand handle = begin(held);
  cycles(700);
  EXPECT_TRUE(given().in_tool_axes);
  EXPECT_EQ(given().feed_forward[2], 15.0);
  handle.cancel();
  EXPECT_TRUE(handle.wait(100).succeeded());
  cycles(700);
  EXPECT_TRUE(given().neutral());
}

TEST_F(ComplianceTest, C8_AnActuatorWithoutTheModeSaysWhatItTakes) {
  const net::Wrench push{.force = {0, 0, 5}};
  RuntimeCommand lamp("lamp", cell.lamp(), with_compliance(set_value(true), CartesianCompliance{.wrench = push}));
  EXPECT_THAT(refusal(lamp), Reports(Code::kInvalidValue, "/lamp", {"C8", "cartesian_impedance", "lamp"}));
}

TEST_F(ComplianceTest, ConstantsThatTheDeviceForbidsAreRefusedAllAtOnce) {
  RuntimeCommand held(
      "hold", cell.arm_actuator(),
      with_compliance(hold(), JointCompliance{.stiffness = joints(2500.0),
                                              .damping_ratio = net::JointArray(Eigen::Vector2d(1, 1))}));
  const Diagnostics why = refusal(held);
  EXPECT_THAT(why, AllOf(Reports(Code::kOutOfRange, "/hold/compliance/stiffness/0", {"2500", "0", "2000"}),
                         Reports(Code::kOutOfRange, "/hold/compliance/stiffness/6", {"2500", "0", "2000"}),
                         Reports(Code::kWrongSize, "/hold/compliance/damping_ratio", {"2"})));
  RuntimeCommand twice("twice", cell.arm_actuator(),
                       with_compliance(with_compliance(hold(), JointCompliance{}), CartesianCompliance{}));
  EXPECT_THAT(refusal(twice), Reports(Code::kConflict, "/twice"));
}

TEST_F(ComplianceTest, L4_InAnotherModeStartIsRefusedWithBoth) {
  RuntimeCommand held("hold", cell.arm_actuator(), with_compliance(hold(), JointCompliance{}));
  EXPECT_THAT(refusal(held), Reports(Code::kNotPossibleNow, "/hold/compliance", {"position", "joint_impedance"}));
  RuntimeCommand stiff("stiff", cell.arm_actuator(), with_compliance(hold(), Stiff{}));
  LoadedCommand going = begin(stiff);
  cycles(10);
  EXPECT_FALSE(going.status().ended());
  going.cancel();
  EXPECT_TRUE(going.wait(100).succeeded());
}

TEST(ComplianceWishTest, AreTheSameIfTheyAskForTheSame) {
  const JointCompliance soft{.stiffness = joints(200.0)};
  EXPECT_TRUE(same(soft, JointCompliance{.stiffness = joints(200.0)}));
  EXPECT_FALSE(same(soft, JointCompliance{.stiffness = joints(201.0)}));
  EXPECT_FALSE(same(soft, JointCompliance{.damping_ratio = joints(200.0)}));
  EXPECT_FALSE(same(CartesianCompliance{}, CartesianCompliance{.in_tool_axes = true}));
  EXPECT_FALSE(same(Stiff{}, JointCompliance{}));
}

}  // namespace
}  // namespace takt::command
