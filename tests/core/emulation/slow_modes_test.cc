// A device with a delay keeps the control modes of the arm behind it.
#include <memory>

#include <gtest/gtest.h>

#include "core/device/arm.h"
#include "core/emulation/slow_arm.h"
#include "tests/support/arm_rig.h"
#include "tests/support/fake_arm.h"

namespace takt::emulation {
namespace {

using device::ControlMode;
using Phase = device::Arm::Phase;
using Vector = device::JointVector;

/// A core with a compliant arm of three joints, 17 ms late, whose changes of the mode take 20 ms.
class SlowModes : public testing::Test {
 protected:
  SlowModes() {
    auto description = std::make_shared<device::ArmDescription>(test::compliant_arm_description(3));
    const device::ControlModes modes = description->modes;
    description->cycle = options.cycle;
    description->sample_age_max = 20 * options.cycle;
    description->modes = SlowArm::delayed(modes, options, kMillisecond);
    machine->change_cycles = 20;
    tap = std::make_shared<test::ArmTap>(machine);
    slow = std::make_shared<SlowArm>("arm", tap, description->limits, options, kMillisecond, 1, modes);
    arm = std::make_unique<device::Arm>("arm", description, slow, kMillisecond);
    EXPECT_TRUE(until([this] { return arm->phase() == Phase::kFrozen; }));
  }

  template <class Propose>
  void cycle(const Propose& propose) {
    arm->begin_cycle(k, k * kMillisecond);
    propose();
    if (const auto trip = arm->check()) ADD_FAILURE() << trip->view();
    arm->hand_over();
    ++k;
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle([] {});
  }
  template <class Condition>
  bool until(const Condition& condition) {
    for (int i = 0; i < 2000 && !condition(); ++i) cycles(1);
    return condition();
  }
  /// Joint 0 goes so far, rest to rest, and the net ends.
  void move(double radians) {
    arm->hold();
    const Vector from = arm->set_point().q;
    const auto law = motion::TimeLaw::rest_to_rest({1.0 / radians, 5.0 / radians, 100.0 / radians});
    for (int i = 0; i * 1e-3 < law.duration() + 1e-3; ++i) {
      const motion::LawPoint at = law.at(i * 1e-3);
      const Vector way = radians * Vector::Unit(3, 0);
      cycle([&] { arm->propose(from + at.s * way, at.ds * way, at.dds * way); });
    }
    arm->release();
    cycles(1);
  }
  void change(ControlMode mode) {
    ASSERT_FALSE(arm->refuse_change(mode)) << arm->refuse_change(mode)->view();
    arm->change_mode(mode);
    ASSERT_TRUE(until([&] { return arm->phase() == Phase::kFrozen; })) << arm->fault_text();
  }

  SlowOptions options{.cycle = kMillisecond, .padding = 14 * kMillisecond};
  std::shared_ptr<test::FakeArm> machine = std::make_shared<test::FakeArm>(Vector::Zero(3));
  std::shared_ptr<test::ArmTap> tap;
  std::shared_ptr<SlowArm> slow;
  std::unique_ptr<device::Arm> arm;
  std::int64_t k = 0;
};

TEST_F(SlowModes, AChangeWaitsForTheSetPointsThatAreOnTheirWay) {
  ASSERT_EQ(options.delay(kMillisecond), 17 * kMillisecond);
  move(0.05);
  arm->change_mode(ControlMode::kJointImpedance);
  EXPECT_EQ(arm->phase(), Phase::kChanging);
  cycles(10);
  EXPECT_EQ(machine->changes, 0) << "it still moves";
  ASSERT_TRUE(until([&] { return machine->changes > 0; }));
  EXPECT_NEAR(tap->told.back().q[0], 0.05, 1e-9);
  EXPECT_TRUE(tap->told.back().dq.isZero(0.0));
  ASSERT_TRUE(until([&] { return arm->phase() == Phase::kFrozen; }));
  EXPECT_EQ(arm->mode(), ControlMode::kJointImpedance);
  EXPECT_NEAR(arm->set_point().q[0], 0.05, 1e-9) << "a spring's rest stays where it is";
  move(0.05);
  EXPECT_EQ(arm->phase(), Phase::kFrozen) << arm->fault_text();
}

TEST_F(SlowModes, CompliancesArriveAndImpedancesChangeInMotion) {
  change(ControlMode::kJointImpedance);
  arm->hold();
  device::Compliance compliance = arm->compliance();
  compliance.stiffness[1] += 2.0;
  const Vector q = arm->set_point().q, rest = Vector::Zero(3);
  cycle([&] { arm->propose(q, rest, rest, compliance); });
  EXPECT_EQ(machine->given.back().stiffness[1], compliance.stiffness[1]);
  machine->change_cycles = 0;
  const device::Compliance tool = arm->description().impedance.standard(ControlMode::kCartesianImpedance);
  for (int i = 0; i < 50; ++i) cycle([&] { arm->propose(q, rest, rest, tool); });
  EXPECT_EQ(machine->state().mode, ControlMode::kCartesianImpedance);
  EXPECT_EQ(arm->phase(), Phase::kFollowing) << arm->fault_text();
}

TEST_F(SlowModes, PositionBeginsWhereASpringWasPushed) {
  change(ControlMode::kJointImpedance);
  machine->deflection = Vector::Constant(3, 0.02);
  cycles(50);
  change(ControlMode::kPosition);
  EXPECT_EQ(arm->mode(), ControlMode::kPosition);
  EXPECT_NEAR(arm->set_point().q[2], 0.02, 1e-9);
  cycles(50);
  EXPECT_NEAR(tap->told.back().q[2], 0.02, 1e-9);
  move(0.05);
  cycles(50);
  EXPECT_NEAR(tap->told.back().q[0], 0.07, 1e-9);
}

TEST_F(SlowModes, OneThatRefusesKeepsItsModeAndMovesOn) {
  machine->ignores_modes = true;
  change(ControlMode::kJointImpedance);
  EXPECT_EQ(arm->mode(), ControlMode::kPosition);
  EXPECT_GT(machine->changes, 0);
  const int asked = machine->changes;
  move(0.05);
  EXPECT_EQ(machine->changes, asked) << "a request does not outlive its time";
  EXPECT_EQ(arm->phase(), Phase::kFrozen) << arm->fault_text();
}

TEST_F(SlowModes, TheDeclaredTimeOfAChangeHasTheDelayInIt) {
  const device::ControlModes modes = test::compliant_arm_description(3).modes;
  const device::ControlModes delayed = SlowArm::delayed(modes, options, kMillisecond);
  const auto* slower = delayed.find(ControlMode::kPosition, ControlMode::kJointImpedance);
  ASSERT_TRUE(slower);
  EXPECT_GE(slower->duration, 20 * kMillisecond + options.delay(kMillisecond));
  const auto* seamless = delayed.find(ControlMode::kJointImpedance, ControlMode::kCartesianImpedance);
  ASSERT_TRUE(seamless);
  EXPECT_EQ(seamless->change, device::ChangeClass::kSeamless);
  EXPECT_EQ(seamless->duration, 0);
  device::ControlModes step = modes;
  step.changes = {{ControlMode::kJointImpedance, ControlMode::kPosition, device::ChangeClass::kSeamless, 0}};
  EXPECT_EQ(SlowArm::delayed(step, options, kMillisecond).changes.front().change, device::ChangeClass::kAtStandstill);
}

}  // namespace
}  // namespace takt::emulation
