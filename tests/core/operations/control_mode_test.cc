// Control modes as activities: queued like motions, known to what follows, refused with the way out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/activity/activity_cell.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using command::JointCompliance;
using device::ControlMode;
using takt::test::Reports;
using testing::AllOf;

net::JointArray joints(double value) {
  return net::JointArray(device::JointVector(device::JointVector::Constant(7, value)));
}

class ControlModeTest : public testing::Test {
 protected:
  Diagnostics error_of(const std::function<void()>& action) {
    try {
      action();
    } catch (const activity::ActivityError& error) {
      return error.diagnostics();
    }
    return {};
  }
  ControlMode mode() const { return cell.core_arm().mode(); }
  void steps(int count) {
    for (int i = 0; i < count; ++i) cell.program.step();
  }

  test::ActivityCell cell;
  app::ControlModeInterface modes = cell.robot.use<app::ControlModeInterface>();
  app::HoldInterface hold = cell.robot.use<app::HoldInterface>();
  const JointCompliance soft{.stiffness = joints(300.0)};
};

TEST_F(ControlModeTest, AChangeWaitsBehindWhatRunsAndWhatFollowsBehindTheChange) {
  const auto goal = cell.joints(0.2), back = cell.joints(0.0);
  const activity::RunPtr there = cell.motion.ptp(goal).begin_execute();
  const activity::RunPtr change = modes.switch_to(ControlMode::kJointImpedance).schedule();
  const activity::RunPtr home = cell.motion.ptp(back, {.compliance = soft}).schedule();
  steps(50);
  EXPECT_EQ(there->state(), activity::RunState::kRunning);
  EXPECT_EQ(change->state(), activity::RunState::kQueued);
  EXPECT_EQ(cell.backend->changes, 0);
  activity::wait(cell.program, change);
  EXPECT_EQ(mode(), ControlMode::kJointImpedance);
  EXPECT_EQ(there->state(), activity::RunState::kCompleted);
  EXPECT_EQ(change->state(), activity::RunState::kCompleted);
  EXPECT_EQ(cell.q(), goal) << "the springs keep the set point";
  activity::wait(cell.program, home);
  EXPECT_LT((cell.q() - back).norm(), 1e-9);
  EXPECT_EQ(cell.backend->given.back().stiffness[0], 300.0);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ControlModeTest, PositionBeginsWhereTheArmIsAndTheNextIsPlannedFromThere) {
  modes.switch_to("cartesian_impedance").execute();
  cell.backend->deflection = device::JointVector::Constant(7, 0.02);  // somebody leans on it
  cell.backend->change_cycles = 20;
  steps(5);
  const auto pushed = cell.backend->state().q;
  const activity::RunPtr change = modes.switch_to(ControlMode::kPosition).schedule();
  const auto goal = cell.joints(0.3);
  const activity::RunPtr go = cell.motion.ptp(goal).schedule();
  activity::wait(cell.program, change);
  EXPECT_EQ(mode(), ControlMode::kPosition);
  EXPECT_EQ(cell.q(), pushed);
  activity::wait(cell.program, go);
  EXPECT_LT((cell.q() - goal).norm(), 1e-9);
}

TEST_F(ControlModeTest, WhatNeedsAnotherModeIsRefusedBeforeAnythingMovesWithTheWayOut) {
  const auto from = cell.q();
  const auto why = error_of([&] { cell.motion.ptp(cell.joints(0.2), {.compliance = soft}).execute(); });
  EXPECT_THAT(why, Reports(Code::kNotPossibleNow, "/arm PTP/compliance", {"joint_impedance", "switch_to"}));
  EXPECT_EQ(cell.q(), from);

  modes.switch_to(ControlMode::kJointImpedance).execute();
  EXPECT_THAT(error_of([&] { hold.hold({.compliance = command::CartesianCompliance{}}).execute(); }),
              Reports(Code::kNotPossibleNow, "/hold arm/compliance", {"cartesian_impedance", "switch_to"}));
  // The predecessor that still runs leaves it in the wrong mode: known while it runs.
  const activity::RunPtr there = cell.motion.ptp(cell.joints(0.2)).begin_execute();
  const activity::RunPtr stiff = cell.motion.ptp(cell.joints(0.0), {.compliance = command::Stiff{}}).schedule();
  steps(20);
  EXPECT_EQ(there->state(), activity::RunState::kRunning);
  EXPECT_EQ(stiff->state(), activity::RunState::kFailed);
  EXPECT_THAT(stiff->diagnostics(), Reports(Code::kNotPossibleNow, "/arm PTP/compliance", {"position", "switch_to"}));
  activity::wait(cell.program, there);
}

TEST_F(ControlModeTest, AHoldGivesWayAndStays) {
  modes.switch_to(ControlMode::kJointImpedance).execute();
  const auto from = cell.q();
  hold.hold({.seconds = 1.0, .compliance = soft}).execute();
  EXPECT_EQ(cell.backend->given.back().stiffness[3], 300.0);
  EXPECT_EQ(cell.q(), from);
  EXPECT_EQ(modes.mode(), ControlMode::kJointImpedance);
}

TEST_F(ControlModeTest, MotionsThatGiveWayAlikeBlend) {
  modes.switch_to(ControlMode::kJointImpedance).execute();
  const MotionParameters soft_blend{.linear_velocity = 0.1, .blend = 0.7, .compliance = soft};
  const Eigen::Isometry3d corner = cell.moved(0, 0.1, 0), end = cell.moved(0.0, 0.1, 0.1);
  const activity::RunPtr first = cell.motion.lin(corner, soft_blend).begin_execute();
  const activity::RunPtr second = cell.motion.lin(end, {.linear_velocity = 0.1, .compliance = soft}).execute();
  EXPECT_TRUE(second->blended());
  EXPECT_EQ(cell.cycles_at_rest(first->first_cycle() + 2, second->last_cycle() - 2), 0);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(ControlModeTest, OtherSpringsComeWhenTheMotionBeforeHasEnded) {
  modes.switch_to(ControlMode::kJointImpedance).execute();
  const Eigen::Isometry3d corner = cell.moved(0, 0.1, 0), end = cell.moved(0.0, 0.1, 0.1);
  const activity::RunPtr first =
      cell.motion.lin(corner, {.linear_velocity = 0.1, .blend = 0.7, .compliance = soft}).begin_execute();
  const activity::RunPtr second =
      cell.motion.lin(end, {.linear_velocity = 0.1, .compliance = JointCompliance{.stiffness = joints(900.0)}})
          .schedule();
  double stiffness = 0.0;
  for (; first->state() == activity::RunState::kRunning; cell.program.step())
    stiffness = cell.backend->given.back().stiffness[3];
  EXPECT_EQ(stiffness, 300.0);
  activity::wait(cell.program, second);
  EXPECT_FALSE(second->blended());
  EXPECT_EQ(cell.backend->given.back().stiffness[3], 900.0);
}

TEST_F(ControlModeTest, ModesThatAreNotThereAndArmsWithOneModeSayWhatIs) {
  EXPECT_THAT(error_of([&] { modes.switch_to("position_impedance").execute(); }),
              Reports(Code::kUnknownName, "/arm", {"cartesian_impedance"}));
  EXPECT_TRUE(cell.robot.offers<app::ControlModeInterface>());
  EXPECT_THAT(error_of([&] { (void)app::Actuator(cell.program, "lamp").use<app::ControlModeInterface>(); }),
              Reports(Code::kUnsupported, "/lamp", {"OutputInterface"}));
}

TEST_F(ControlModeTest, AChangeIsNoPartOfANet) {
  const auto why = error_of([&] {
    activity::sequence({modes.switch_to(ControlMode::kJointImpedance), cell.motion.ptp(cell.joints(0.1))}).execute();
  });
  EXPECT_THAT(why, Reports(Code::kConflict, "/arm joint_impedance, arm PTP/0"));
}

TEST_F(ControlModeTest, L4_ADeviceThatDoesNotComeThereIsAFailure) {
  cell.backend->ignores_modes = true;
  EXPECT_THAT(error_of([&] { modes.switch_to(ControlMode::kJointImpedance).execute(); }),
              Reports(Code::kNotPossibleNow, "/arm joint_impedance/mode"));
  EXPECT_EQ(mode(), ControlMode::kPosition);
  cell.motion.ptp(cell.joints(0.1)).execute();
}

TEST_F(ControlModeTest, WhoCancelsAQueuedChangeChangesNothingARunningOneIsLedToItsEnd) {
  const activity::RunPtr there = cell.motion.ptp(cell.joints(0.2)).begin_execute();
  const activity::RunPtr never = modes.switch_to(ControlMode::kJointImpedance).schedule();
  steps(5);
  never->cancel();
  activity::wait(cell.program, there);
  EXPECT_EQ(never->state(), activity::RunState::kCancelled);
  EXPECT_EQ(cell.backend->changes, 0);

  const activity::RunPtr change = modes.switch_to(ControlMode::kJointImpedance).begin_execute();
  const activity::RunPtr behind = cell.motion.ptp(cell.joints(0.0)).schedule();
  change->cancel();
  while (!change->over()) cell.program.step();
  EXPECT_EQ(change->state(), activity::RunState::kCancelled);
  EXPECT_EQ(mode(), ControlMode::kJointImpedance);
  steps(2);
  EXPECT_EQ(behind->state(), activity::RunState::kFailed) << "given up";
}

class FreedriveActivityTest : public ControlModeTest {
 protected:
  /// An arm that a hand has bent away from its springs' rest, as long as it is soft.
  void bend(double angle) { cell.backend->deflection = device::JointVector::Constant(7, angle); }
  app::FreedriveInterface guide = cell.robot.use<app::FreedriveInterface>();
  expression::State button = holds(expression::channel<bool>(cell.cell, "enable"));
  void steps_with_button(int count, bool held) {
    for (int i = 0; i < count; ++i) {
      cell.cell.channels.at("enable")->write(held);
      cell.program.step();
    }
  }
};

TEST_F(FreedriveActivityTest, TheSetPointGoesAfterTheHandWhileTheButtonIsHeld) {
  const auto from = cell.q();
  const activity::RunPtr run = guide.freedrive({.enabled = button}).begin_execute();
  EXPECT_EQ(mode(), ControlMode::kJointImpedance);
  bend(0.05);
  steps_with_button(500, false);
  EXPECT_EQ(cell.q(), from) << "nobody has it in hand";
  EXPECT_EQ(cell.backend->given.back().stiffness[0], 2000.0) << "and it is stiff";
  steps_with_button(1000, true);
  EXPECT_EQ(cell.backend->given.back().stiffness[0], 100.0);
  EXPECT_GT((cell.q() - from).minCoeff(), 0.02);
  const auto held = cell.q();
  steps_with_button(1, true);
  const Eigen::VectorXd rate = (cell.q() - held) / 1e-3;
  EXPECT_GT(rate.norm(), 0.01);
  // Let go: at rest within the time that the limits allow, and stiff; silence is as good as let go.
  steps_with_button(400, false);
  EXPECT_TRUE(cell.core_arm().at_rest());
  EXPECT_FALSE(run->over());
  steps_with_button(300, true);
  EXPECT_FALSE(cell.core_arm().at_rest());
  steps(500);
  EXPECT_TRUE(cell.core_arm().at_rest()) << "the channel is too old";
  EXPECT_EQ(cell.backend->given.back().stiffness[0], 2000.0);
  bend(0.0);
  run->cancel();
  while (!run->over()) cell.program.step();
  EXPECT_EQ(run->state(), activity::RunState::kCancelled);
  EXPECT_EQ(mode(), ControlMode::kPosition) << "back in the mode before";
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(FreedriveActivityTest, TheNextMotionBeginsWhereTheHandHasLedIt) {
  const activity::RunPtr run = guide.freedrive({.seconds = 1.5}).begin_execute();
  const activity::RunPtr after = cell.motion.ptp(cell.joints(0.0)).schedule();
  bend(0.05);
  steps(1200);
  bend(0.0);
  while (!run->over()) cell.program.step();
  EXPECT_EQ(run->state(), activity::RunState::kCompleted);
  EXPECT_GT((cell.q() - cell.arm->home).norm(), 0.1) << "it has been led away";
  activity::wait(cell.program, after);
  EXPECT_LT((cell.q() - cell.arm->home).norm(), 1e-9);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(FreedriveActivityTest, ASmallBendIsNoHandAndAPauseHoldsIt) {
  const auto from = cell.q();
  const activity::RunPtr run = guide.freedrive().begin_execute();
  bend(0.9 * 1.5 / 100.0);
  steps(500);
  EXPECT_EQ(cell.q(), from) << "less than the torque that counts";
  bend(0.05);
  cell.robot.pause();
  steps(1000);
  EXPECT_TRUE(cell.core_arm().at_rest());
  cell.robot.resume();
  steps(300);
  EXPECT_GT((cell.q() - from).norm(), 0.01);
  run->cancel();
  bend(0.0);
  while (!run->over()) cell.program.step();
}

TEST_F(FreedriveActivityTest, AfterAFailureItBrakesAndGoesBackIntoTheModeBeforeToo) {
  const activity::RunPtr run = guide.freedrive().begin_execute();
  const activity::RunPtr behind = cell.motion.ptp(cell.joints(0.0)).schedule();
  bend(0.05);
  steps(1000);
  ASSERT_FALSE(cell.core_arm().at_rest());
  run->abort();
  bool soft_while_it_braked = false;
  for (int i = 0; i < 5000 && !run->over(); ++i) {
    cell.program.step();
    soft_while_it_braked = soft_while_it_braked || mode() == ControlMode::kJointImpedance;
    if (cell.core_arm().at_rest()) bend(0.0);  // the hand has let go
  }
  EXPECT_TRUE(soft_while_it_braked);
  EXPECT_EQ(run->state(), activity::RunState::kFailed);
  EXPECT_EQ(run->diagnostics().list().size(), 1u) << run->diagnostics().to_string();
  EXPECT_THAT(run->diagnostics(), Reports(Code::kStopped, "/arm freedrive", {"arm freedrive"}));
  EXPECT_EQ(mode(), ControlMode::kPosition);
  steps(2);
  EXPECT_EQ(behind->state(), activity::RunState::kFailed) << "given up";
  cell.motion.ptp(cell.joints(0.1)).execute();
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(FreedriveActivityTest, WhereTheWayBackFailsTooBothAreTold) {
  const activity::RunPtr run = guide.freedrive().begin_execute();
  steps(100);
  cell.backend->ignores_modes = true;
  run->abort();
  for (int i = 0; i < 5000 && !run->over(); ++i) cell.program.step();
  EXPECT_EQ(run->state(), activity::RunState::kFailed);
  EXPECT_THAT(run->diagnostics(),
              AllOf(Reports(Code::kStopped, "/arm freedrive"), Reports(Code::kNotPossibleNow, "/arm freedrive/mode"),
                    Reports(Code::kNotPossibleNow, "/arm freedrive/mode", {"arm", "joint_impedance"})));
  EXPECT_FALSE(cell.core_arm().held());
}

TEST_F(FreedriveActivityTest, AModeThatIsNotReachedLeavesTheOneBefore) {
  cell.backend->ignores_modes = true;
  EXPECT_THAT(error_of([&] { guide.freedrive().execute(); }),
              Reports(Code::kNotPossibleNow, "/arm freedrive/mode", {"arm"}));
  EXPECT_EQ(mode(), ControlMode::kPosition);
}

TEST_F(FreedriveActivityTest, AtTheEndOfAJointsRangeItResistsAndNoLimitIsBroken) {
  const activity::RunPtr run = guide.freedrive({.velocity = 1.0, .turn = 3.0}).begin_execute();
  bend(0.3);
  steps(12'000);
  EXPECT_EQ(run->state(), activity::RunState::kRunning) << run->diagnostics().to_string();
  EXPECT_LE((cell.q() - cell.arm->limits.upper).maxCoeff(), -0.02 + 1e-9) << "with room for the bend";
  EXPECT_GT((cell.q() - cell.arm->limits.upper).maxCoeff(), -0.021) << "one is at its end";
  EXPECT_LE(cell.worst_limit_share(), 1.0);
  bend(0.0);
  run->cancel();
  while (!run->over()) cell.program.step();
}

TEST_F(FreedriveActivityTest, TheToolIsNeverMuchFasterThanAllowed) {
  const activity::RunPtr run = guide.freedrive({.velocity = 0.1}).begin_execute();
  double fastest = 0.0;
  Eigen::Vector3d last = cell.robot.tool().translation();
  for (int i = 0; i < 3000; ++i) {
    bend(i < 1500 ? 0.3 : -0.2);
    cell.program.step();
    const Eigen::Vector3d now = cell.robot.tool().translation();
    fastest = std::max(fastest, (now - last).norm() / 1e-3);
    last = now;
  }
  EXPECT_GT(fastest, 0.09);
  EXPECT_LT(fastest, 0.11);
  bend(0.0);
  run->cancel();
  while (!run->over()) cell.program.step();
}

}  // namespace
}  // namespace takt::operations
