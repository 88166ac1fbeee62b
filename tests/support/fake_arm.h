#pragma once

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/device/arm.h"

namespace takt::test {

/// An arm without a body: it is always exactly where it was sent. Remembers all that it was sent.
class FakeArm final : public device::ArmBackend {
 public:
  explicit FakeArm(const device::JointVector& q) {
    sample_.q = q;
    sample_.dq = device::JointVector::Zero(q.size());
    sample_.ready = true;
    given.reserve(kKept / 8);
    sent.reserve(kKept);  // pages that are not used cost nothing; a cycle must not allocate
  }
  static constexpr std::size_t kKept = 1u << 17;

  /// Once in a cycle of 1 ms. In a cycle without a set point it stands.
  bool read(device::ArmSample& sample) override {
    if (!std::exchange(written_, false) && sample_.sequence > 0) {
      now += kMillisecond;
      sample_.dq.setZero();
    }
    if (silent) return false;
    if (sample_.changing_mode && --change_cycles_left <= 0) take_mode(target_);
    ++sample_.sequence;
    sample_.stamp = now;
    sample = sample_;
    return true;
  }
  void write(const device::ArmSetPoint& set_point) override {
    if (!sample_.ready) return;
    written_ = true;
    now = set_point.stamp + kMillisecond;
    if (keep) sent.push_back(set_point);
    last_written_cycle = set_point.cycle;
    sample_.q = set_point.q;
    if (sample_.mode != device::ControlMode::kPosition && deflection.size() > 0) sample_.q += deflection;
    sample_.dq = set_point.dq;
  }
  void write_compliance(const device::Compliance& compliance) override { given.push_back(compliance); }
  void change_mode(device::ControlMode mode) override {
    ++changes;
    if (ignores_modes) return;
    if (change_cycles == 0) return take_mode(mode);
    sample_.changing_mode = true;
    target_ = mode;
    change_cycles_left = change_cycles;
  }
  void take_mode(device::ControlMode mode) {
    sample_.mode = mode;
    sample_.changing_mode = false;
  }
  void set_payload(const device::PayloadSetting& setting) override { payload = setting; }
  void brake() override {
    ++brakes;
    sample_.ready = false;
    sample_.dq.setZero();
  }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return fault == 0 ? "" : "fake fault"; }

  device::ArmSample& state() { return sample_; }

  bool keep = true;
  bool silent = false;
  int brakes = 0;
  std::int64_t last_written_cycle = -1;
  Nanoseconds now = 0;
  device::PayloadSetting payload;
  std::vector<device::ArmSetPoint> sent;
  std::vector<device::Compliance> given;
  int changes = 0;                 ///< of mode that were asked for
  int change_cycles = 0;           ///< that a change takes
  bool ignores_modes = false;      ///< never changes its mode
  device::JointVector deflection;  ///< of an arm that gives way, from its set point, rad

 private:
  int change_cycles_left = 0;
  device::ControlMode target_ = device::ControlMode::kPosition;
  device::ArmSample sample_;
  bool written_ = false;
};

/// An arm model without geometry.
inline device::ArmDescription fake_arm_description(int joint_count) {
  device::ArmDescription arm;
  arm.model = "fake";
  for (int i = 0; i < joint_count; ++i) arm.joint_names.push_back("a" + std::to_string(i + 1));
  arm.limits = {.lower = device::JointVector::Constant(joint_count, -3.0),
                .upper = device::JointVector::Constant(joint_count, 3.0),
                .velocity = device::JointVector::Constant(joint_count, 2.0),
                .acceleration = device::JointVector::Constant(joint_count, 10.0),
                .jerk = device::JointVector::Constant(joint_count, 200.0)};
  arm.home = device::JointVector::Zero(joint_count);
  arm.start_tolerance = 0.005;
  return arm;
}

/// The same with all three modes: position to joint impedance at standstill (20 ms), between the two impedances
/// seamless, Cartesian impedance to position outside a net (50 ms). What is not listed is forbidden.
inline device::ArmDescription compliant_arm_description(int joint_count) {
  using device::ChangeClass, device::ControlMode, device::JointVector;
  device::ArmDescription arm = fake_arm_description(joint_count);
  constexpr auto kStiff = ControlMode::kPosition, kJoint = ControlMode::kJointImpedance,
                 kTool = ControlMode::kCartesianImpedance;
  arm.modes.modes = {kStiff, kJoint, kTool};
  arm.modes.changes = {{kStiff, kJoint, ChangeClass::kAtStandstill, 20 * kMillisecond},
                       {kJoint, kStiff, ChangeClass::kAtStandstill, 20 * kMillisecond},
                       {kJoint, kTool, ChangeClass::kSeamless, 0},
                       {kTool, kJoint, ChangeClass::kSeamless, 0},
                       {kTool, kStiff, ChangeClass::kOutsideNet, 50 * kMillisecond}};
  const auto fill = [](device::ComplianceRange& range, ControlMode mode, int axes) {
    for (device::Compliance* part : {&range.lower, &range.upper, &range.standard}) {
      part->mode = mode;
      part->stiffness = part->damping_ratio = part->feed_forward = JointVector::Zero(axes);
    }
    range.upper.stiffness.setConstant(2000.0);
    range.standard.stiffness.setConstant(1000.0);
    range.lower.damping_ratio.setConstant(0.1);
    range.upper.damping_ratio.setConstant(1.0);
    range.standard.damping_ratio.setConstant(0.7);
    range.lower.feed_forward.setConstant(-50.0);
    range.upper.feed_forward.setConstant(50.0);
  };
  fill(arm.impedance.joint, kJoint, joint_count);
  fill(arm.impedance.cartesian, kTool, 6);
  arm.impedance.cartesian.upper.nullspace_stiffness = 100.0;
  arm.impedance.cartesian.upper.nullspace_damping_ratio = 1.0;
  arm.impedance.ramp = kSecond / 2;
  return arm;
}

/// A force/torque sensor that reads what the test says.
class FakeForceTorqueSensor final : public device::ForceTorqueBackend {
 public:
  bool read(device::WrenchSample& out) override {
    if (silent) return false;
    sample.stamp = static_cast<Nanoseconds>(sample.sequence++) * kMillisecond;  // read once in a cycle of 1 ms
    out = sample;
    return true;
  }
  bool silent = false;
  device::WrenchSample sample;
};

}  // namespace takt::test
