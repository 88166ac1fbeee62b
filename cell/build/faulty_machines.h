#pragma once

#include <memory>
#include <optional>
#include <string>

#include "cell/file/fault_point.h"
#include "core/base/random.h"
#include "core/device/backend.h"
#include "core/device/gripper.h"

namespace takt::cell {

/// What faults make of the connection to a machine. Realtime: cyclic.
class ConnectionFaults {
 public:
  void begin(const DeviceFault& fault, std::uint64_t seed, std::string_view name) {
    fault_ = fault;
    random_ = Random(seed ^ 0xFA17, name);
  }
  void end() { fault_.reset(); }

  [[nodiscard]] bool gone() const { return fault_ && fault_->kind == DeviceFault::Kind::kGone; }
  /// Draws: this message, in either direction, is lost.
  [[nodiscard]] bool loses() {
    return fault_ && fault_->kind == DeviceFault::Kind::kLoss && random_.unit() < fault_->share;
  }
  /// What it is told arrives, and has an effect.
  [[nodiscard]] bool arrives() {
    return !gone() && !(fault_ && fault_->kind == DeviceFault::Kind::kJammed) && !loses();
  }

 private:
  std::optional<DeviceFault> fault_;
  Random random_{0, ""};
};

/// An arm or a base whose connection to the core can be told to fail: gone, or with loss. What the core sends as a set
/// point is a message and may be lost; what it does once (mode, tool, brakes) is only lost with a machine that is gone,
/// as drivers repeat it until it is confirmed. Thread: the cycle's. Realtime: cyclic.
class FaultyArm final : public device::ArmBackend, public FaultPoint {
 public:
  explicit FaultyArm(std::shared_ptr<device::ArmBackend> machine) : machine_(std::move(machine)) {}

  [[nodiscard]] std::span<const DeviceFault::Kind> kinds() const override;
  void begin(const DeviceFault& fault, std::uint64_t seed, std::string_view name) override {
    faults_.begin(fault, seed, name);
  }
  void end() override { faults_.end(); }

  bool read(device::ArmSample& sample) override;
  void set_held(bool held) override { machine_->set_held(held); }
  void write(const device::ArmSetPoint& set_point) override {
    if (faults_.arrives()) machine_->write(set_point);
  }
  void write_compliance(const device::Compliance& compliance) override {
    if (!faults_.gone()) machine_->write_compliance(compliance);
  }
  void change_mode(device::ControlMode mode) override {
    if (!faults_.gone()) machine_->change_mode(mode);
  }
  void set_payload(const device::PayloadSetting& payload) override { machine_->set_payload(payload); }
  void set_tool(const device::ToolSetting& tool) override { machine_->set_tool(tool); }
  void brake() override {
    if (!faults_.gone()) machine_->brake();
  }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return machine_->fault_text(fault); }
  [[nodiscard]] device::BackendTiming timing() const override { return machine_->timing(); }

 private:
  std::shared_ptr<device::ArmBackend> machine_;
  ConnectionFaults faults_;
  std::optional<device::ArmSample> given_;  ///< what the core got last
};

/// The same of a gripper; its fingers may be jammed, too. Thread: the cycle's. Realtime: cyclic.
class FaultyGripper final : public device::GripperBackend, public FaultPoint {
 public:
  explicit FaultyGripper(std::shared_ptr<device::GripperBackend> machine) : machine_(std::move(machine)) {}

  [[nodiscard]] std::span<const DeviceFault::Kind> kinds() const override;
  void begin(const DeviceFault& fault, std::uint64_t seed, std::string_view name) override {
    faults_.begin(fault, seed, name);
  }
  void end() override { faults_.end(); }

  bool read(device::GripperSample& sample) override;
  void write(const device::GripperSetPoint& set_point) override {
    if (faults_.arrives()) machine_->write(set_point);
  }

 private:
  std::shared_ptr<device::GripperBackend> machine_;
  ConnectionFaults faults_;
  std::optional<device::GripperSample> given_;
};

}  // namespace takt::cell
