// What actuators offer beside planned motions: velocities, single joints, measured values, interfaces of a project;
// several actuators as one device.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/activity/command_activity.h"
#include "core/activity/composed_device.h"
#include "core/command/actions/online_action.h"
#include "tests/core/activity/activity_cell.h"
#include "tests/core/activity/two_arm_cell.h"

namespace takt::activity {
namespace {

using command::channel;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::string error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const ActivityError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

class InterfacesTest : public testing::Test {
 protected:
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) cell.program.step();
  }
  void write_stick(const Eigen::Vector3d& linear, bool enabled) {
    cell.cell.channels.at("stick")->write(net::Twist{.linear = linear, .angular = Eigen::Vector3d::Zero()});
    cell.cell.channels.at("enable")->write(enabled);
  }
  test::ActivityCell cell;
};

// 2013, 4.4: manual control by a channel that the program writes while the activity runs.
TEST_F(InterfacesTest, AProgramJogsAnArmByAChannel) {
  const auto jog = cell.robot.use<VelocityInterface>().jog(
      channel<net::Twist>(cell.cell, "stick"), command::State(channel<net::Boolean>(cell.cell, "enable").node()),
      {.linear_max = 0.05});
  const Eigen::Isometry3d X_begin = cell.robot.tool();
  const RunPtr jogging = jog.begin_execute();
  const auto way = [&] { return (cell.robot.tool().translation() - X_begin.translation()).y(); };
  for (int i = 0; i < 1000; ++i) {
    write_stick({0.0, 1.0, 0.0}, true);
    run(1);
  }
  EXPECT_NEAR(way(), 0.05, 0.01) << "a second at its bound, but for the ramp";
  const double before = way();
  cell.robot.pause();
  for (int i = 0; i < 500; ++i) {
    write_stick({0.0, 1.0, 0.0}, true);
    run(1);
  }
  EXPECT_LT(way(), before + 0.02);
  const double paused = way();
  for (int i = 0; i < 500; ++i) {
    write_stick({0.0, 1.0, 0.0}, true);
    run(1);
  }
  EXPECT_NEAR(way(), paused, 1e-9) << "a pause counts here too";
  cell.robot.resume();
  run(200);
  EXPECT_TRUE(cell.core_arm().at_rest()) << "the dead-man switch does not answer any more";
  jogging->cancel();
  cell.program.run_until([&] { return jogging->over(); });
  EXPECT_EQ(jogging->state(), RunState::kCancelled);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(InterfacesTest, AnArmFollowsJointsUntilAStateHolds) {
  const auto posture = channel<net::JointArray>(cell.cell, "posture");
  const kinematics::JointVector goal = cell.joints(0.2, -0.1);
  cell.cell.channels.at("posture")->write(net::JointArray(goal));
  const auto there = near(command::commanded_joints(cell.cell, "arm"), net::JointArray(goal), 1e-6);
  const RunPtr followed = cell.robot.use<VelocityInterface>().follow(posture, 0.5, there).execute();
  EXPECT_EQ(followed->state(), RunState::kCompleted);
  EXPECT_LT((cell.robot.q() - goal).norm(), 1e-5);
}

TEST_F(InterfacesTest, OneJointMovesAndTheOthersStand) {
  const kinematics::JointVector before = cell.robot.q();
  const auto joint = cell.robot.use<JointInterface>();
  joint.move_to(3, before[3] - 0.3).execute();
  joint.move_by(3, 0.1, {.velocity = 0.5}).execute();
  kinematics::JointVector expected = before;
  expected[3] -= 0.2;
  EXPECT_LT((cell.robot.q() - expected).norm(), 1e-9);
  EXPECT_THAT(error_of([&] { (void)joint.move_to(7, 0.0); }), AllOf(HasSubstr("no joint 7"), HasSubstr("0 to 6")));
  EXPECT_THAT(error_of([&] { joint.move_to(3, 9.0).execute(); }), HasSubstr("9"));
}

TEST_F(InterfacesTest, WhatIsMeasuredIsToldBesideTheSetPoint) {
  cell.motion.lin_by({0.0, 0.05, 0.0}).begin_execute();
  run(100);
  EXPECT_EQ(cell.robot.measured_q(), cell.cell.arms.at("arm").device->sample().q);
  const Eigen::Isometry3d X_BT = cell.arm->chain->forward(cell.robot.measured_q()) * cell.cell.arms.at("arm").X_FT;
  EXPECT_TRUE(cell.robot.measured_tool().isApprox(X_BT, 1e-12));
  EXPECT_NE(cell.robot.measured_q(), cell.robot.q()) << "a cycle behind while it moves";
}

TEST(ForceInterfaceTest, AnArmPressesWithItsOwnSensorOnly) {
  test::TwoArmCell cell;
  const Actuator left(cell.program, "left");
  const Eigen::Vector3d down(0.0, 0.0, -1.0);
  const auto press_with = [&](const char* sensor) {
    const auto pressing = command::pressing_force(cell.cell, sensor, down);
    return [=] { (void)left.use<ForceInterface>().press(pressing, down); };
  };
  EXPECT_EQ(error_of(press_with("left wrist")), "nothing was thrown");
  EXPECT_THAT(error_of(press_with("right wrist")),
              AllOf(HasSubstr("'right wrist' is on 'right', not on 'left'"), HasSubstr("of the arm that presses")));
  cell.cell.sensors.erase("left wrist");
  EXPECT_FALSE(left.offers<ForceInterface>());
  EXPECT_THAT(left.interfaces(), Not(Contains("ForceInterface")));
}

/// An interface that a project brings.
class PolishInterface : public ActuatorInterface {
 public:
  static constexpr std::string_view kName = "PolishInterface";
  static bool offered_by(const command::Cell& cell, const std::string& actuator) {
    return cell.arms.contains(actuator);
  }
  using ActuatorInterface::ActuatorInterface;
};
const RegisterInterface<PolishInterface> kPolish;

TEST_F(InterfacesTest, AnInterfaceOfAProjectIsListed) {
  EXPECT_THAT(cell.robot.interfaces(), Contains("PolishInterface"));
  EXPECT_THAT(Actuator(cell.program, "lamp").interfaces(), Not(Contains("PolishInterface")));
  EXPECT_EQ(cell.robot.use<PolishInterface>().actuator(), "arm");
}

// 2013, 4.4: a command is scheduled after another one; no cycle is lost between them.
TEST_F(InterfacesTest, CommandsFollowEachOtherWithoutAnEmptyCycle) {
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

TEST_F(InterfacesTest, WhatFollowsACommandThatMayBeCutShortWaitsForItsEnd) {
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
TEST_F(InterfacesTest, AbortIfFailsEveryOperationThatMovesSomething) {
  const auto button = command::digital_input(cell.cell, "button");
  const Eigen::Vector3d down(0.0, 0.0, -1.0);
  const auto pressing = command::pressing_force(cell.cell, "wrist", down);
  const auto target = command::Sensor<net::Frame>(command::tool_pose(cell.cell, "arm").node());
  const Actuator lamp(cell.program, "lamp");
  const std::vector<Activity> all{
      cell.motion.lin_by({0.0, 0.08, 0.0}),
      cell.motion.ptp(cell.joints(0.3)),
      cell.robot.use<JointInterface>().move_by(0, 0.3),
      cell.robot.use<HoldInterface>().hold(),
      cell.robot.use<ForceInterface>().press(pressing, down),
      cell.robot.use<VelocityInterface>().follow(target),
      sequence({lamp.use<OutputInterface>().set(true), cell.motion.lin_by({0.0, 0.0, 0.05})}),
      parallel({cell.motion.lin_by({0.05, 0.0, 0.0}), lamp.use<OutputInterface>().set(false)})};
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

TEST_F(InterfacesTest, AbortIfThatNeverHoldsChangesNothingAndASilentSensorAborts) {
  const auto button = command::digital_input(cell.cell, "button");
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
TEST_F(InterfacesTest, AbortIfOfAMotionHoldsThroughItsBlend) {
  const Eigen::Isometry3d goal = cell.moved(0.0, 0.1, 0.0), goal2 = cell.moved(-0.1, 0.1, 0.0);
  const auto button = command::digital_input(cell.cell, "button");
  const RunPtr first =
      cell.motion.lin(goal, {.linear_velocity = 0.1, .blend = 0.7, .abort_if = button}).begin_execute();
  const RunPtr second = cell.motion.lin(goal2, {.linear_velocity = 0.1}).begin_execute();
  ASSERT_TRUE(second->blended());
  cell.button->sample.value = true;
  cell.program.run_until([&] { return second->over(); });
  EXPECT_EQ(first->state(), RunState::kCompleted);
  EXPECT_EQ(second->failure(), RunFailure::kAborted);
  EXPECT_EQ(second->diagnostics().list().front().pointer, "/arm LIN/abort_if");
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

// 2010: a welding robot is a robot with its torch.
TEST_F(InterfacesTest, SeveralActuatorsAreOneDevice) {
  const ComposedDevice welder("welder", {cell.robot, Actuator(cell.program, "lamp")});
  EXPECT_TRUE(welder.offers<LinInterface>());
  EXPECT_FALSE(welder.offers<GrippingInterface>());
  EXPECT_THAT(welder.interfaces(), AllOf(Contains("OutputInterface"), Contains("LinInterface")));
  sequence({welder.use<LinInterface>().lin_by({0.0, 0.05, 0.0}), welder.use<OutputInterface>().set(true)}).execute();
  EXPECT_TRUE(cell.cell.digital_outputs.at("lamp")->value());
  EXPECT_EQ(welder.part("arm").name(), "arm");
  welder.set_speed(0.5);
  EXPECT_EQ(std::get<double>(cell.cell.channels.at("arm.speed")->newest().value()), 0.5);

  EXPECT_THAT(error_of([&] { (void)welder.part("lam"); }), AllOf(HasSubstr("no part 'lam'"), HasSubstr("'lamp'")));
  EXPECT_THAT(error_of([&] { (void)welder.use<GrippingInterface>(); }), HasSubstr("no part of 'welder'"));
  const ComposedDevice lamps("lamps", {Actuator(cell.program, "lamp"), Actuator(cell.program, "driver")});
  EXPECT_THAT(error_of([&] { (void)lamps.use<OutputInterface>(); }), HasSubstr("part() of one of lamp, driver"));
  EXPECT_THAT(lamps.interfaces(), ElementsAre());
  EXPECT_THAT(error_of([&] { (void)ComposedDevice("none", {}); }), HasSubstr("without parts"));
  EXPECT_THAT(error_of([&] { (void)ComposedDevice("twice", {cell.robot, cell.robot}); }), HasSubstr("twice"));
}

}  // namespace
}  // namespace takt::activity
