#pragma once

#include <memory>

#include "core/base/clock.h"
#include "hw/emulators/rtde/emulated_robot.h"
#include "hw/rtde/driver.h"
#include "hw/wire/virtual_network.h"

namespace takt::hw::rtde {

/// Driver and emulated controller in one thread and on virtual time: read() makes time go on by one core cycle, so it
/// is called once in each. On a virtual wire the same seed gives the same run, bit for bit.
class LockStepRobot final : public device::ArmDriver {
 public:
  /// @param machine  the arm behind the controller, which lives in the core's cycle @param sockets  in place of the
  /// virtual wire: real sockets, whose packages take no virtual time; outlives it. Null: the virtual wire
  LockStepRobot(const DriverOptions& options, const ControllerOptions& controller, const device::DriverRequest& request,
                std::shared_ptr<device::ArmBackend> machine, const hw::VirtualFaults& faults,
                const emulation::DeviceClock& device_clock = {}, hw::Network* sockets = nullptr);

  /// Opens the controller's ports. Realtime: setup.
  [[nodiscard]] Result<void> begin() { return robot_.listen(options_.host); }

  void set_held(bool held) override { driver_.set_held(held); }
  bool read(device::ArmSample& sample) override;
  void write(const device::ArmSetPoint& set_point) override { driver_.write(set_point); }
  void set_payload(const device::PayloadSetting& payload) override;
  void brake() override { driver_.brake(); }
  /// Who resets the arm in a scenario looks after its robot, too: a protective stop is unlocked, where that is allowed
  /// yet.
  void reset() override;
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return driver_.fault_text(fault); }
  [[nodiscard]] device::BackendTiming timing() const override { return driver_.timing(); }
  [[nodiscard]] device::ForceTorqueBackend* force_torque() override { return driver_.force_torque(); }
  [[nodiscard]] device::IoDriver* terminals(const device::IoTerminals& machine) override;
  [[nodiscard]] device::ConnectionCounts connection() const override { return driver_.connection(); }
  [[nodiscard]] std::string refusal() const override { return driver_.refusal(); }
  [[nodiscard]] std::vector<std::string> news() override { return driver_.news(); }
  [[nodiscard]] std::span<const std::byte> state() const override { return state_.bytes(); }

  /// A core cycle in which the core does nothing.
  void pass_cycle();
  [[nodiscard]] Driver& driver() { return driver_; }
  [[nodiscard]] EmulatedRobot& robot() { return robot_; }
  [[nodiscard]] hw::VirtualNetwork& network() { return network_; }
  /// The driver's thread does not run: a process that is stopped.
  bool frozen = false;

 private:
  void advance(Nanoseconds now);
  void serve(Nanoseconds now);

  DriverOptions options_;
  Nanoseconds period_;
  std::shared_ptr<const device::IoDescription> block_;  // null: nobody asked for terminals
  std::shared_ptr<device::ArmBackend> machine_;
  VirtualClock clock_;
  hw::VirtualNetwork network_;
  bool on_sockets_;
  EmulatedRobot robot_;
  Driver driver_;
  std::int64_t cycle_ = -1;
  emulation::StateHash state_;
};

}  // namespace takt::hw::rtde
