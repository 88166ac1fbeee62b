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
    sample_.dq = set_point.dq;
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

 private:
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
