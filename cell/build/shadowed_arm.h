#pragma once

#include <memory>
#include <utility>

#include "core/device/driver.h"

namespace takt::cell {

/// An arm behind a driver, and its simulated body, which is shown where the arm is: pictures, and simulated devices on
/// its flange, follow. Nothing of the body reaches the arm. Thread: the cycle's. Realtime: cyclic.
class ShadowedArm final : public device::ArmBackend {
 public:
  ShadowedArm(std::shared_ptr<device::ArmDriver> driver, std::shared_ptr<device::ArmBackend> body)
      : driver_(std::move(driver)), body_(std::move(body)) {}

  void set_held(bool held) override { driver_->set_held(held); }
  bool read(device::ArmSample& sample) override {
    const bool any = driver_->read(sample);
    if (any) follow(sample);
    return any;
  }
  void write(const device::ArmSetPoint& set_point) override { driver_->write(set_point); }
  void write_compliance(const device::Compliance& compliance) override { driver_->write_compliance(compliance); }
  void change_mode(device::ControlMode mode) override { driver_->change_mode(mode); }
  void set_payload(const device::PayloadSetting& payload) override {
    driver_->set_payload(payload);
    body_->set_payload(payload);
  }
  void set_tool(const device::ToolSetting& tool) override {
    driver_->set_tool(tool);
    body_->set_tool(tool);
  }
  void brake() override { driver_->brake(); }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return driver_->fault_text(fault); }
  [[nodiscard]] device::BackendTiming timing() const override { return driver_->timing(); }

 private:
  void follow(const device::ArmSample& sample) {
    if (!sample.q.allFinite() || !sample.dq.allFinite()) return;
    body_->write({.cycle = ++cycle_,
                  .stamp = sample.stamp,
                  .q = sample.q,
                  .dq = sample.dq,
                  .ddq = device::JointVector::Zero(sample.q.size())});
  }

  std::shared_ptr<device::ArmDriver> driver_;
  std::shared_ptr<device::ArmBackend> body_;
  std::int64_t cycle_ = 0;
};

}  // namespace takt::cell
