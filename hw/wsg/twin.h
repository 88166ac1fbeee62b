#pragma once

#include <memory>

#include "hw/emulators/wsg/emulator.h"
#include "hw/wire/virtual_network.h"
#include "hw/wsg/driver.h"

namespace takt::hw::wsg {

/// How a twin differs from a gripper that lives in the core's cycle.
struct TwinOptions {
  ClientOptions client;
  EmulatorOptions emulator;
  VirtualFaults faults;
};

/// What a twin is made of, in the order in which it has to be made.
struct TwinParts {
  TwinParts(std::uint64_t seed, const VirtualFaults& faults) : wire(clock, seed, faults) {}
  VirtualClock clock;
  VirtualNetwork wire;
};

/// The driver and the emulated gripper in one process, in lock-step: read() makes time go on by one core cycle, so it
/// is called once in each. On the virtual wire the same seed gives the same bits.
/// Realtime: cyclic but for the constructor, the set-up of a connection, and news().
class Twin final : private TwinParts, public Backend {
 public:
  Twin(const device::GripperRequest& request, const TwinOptions& options,
       std::shared_ptr<device::GripperBackend> machine);
  /// Opens the gripper's port. Realtime: setup.
  [[nodiscard]] Result<void> begin() { return emulator_.listen(remote_); }

  bool read(device::GripperSample& sample) override;
  [[nodiscard]] std::vector<std::string> news() override;
  [[nodiscard]] std::span<const std::byte> state() const override { return state_.bytes(); }

  /// A core cycle in which the core does nothing.
  void pass_cycle() { advance(++core_cycle_ * core_period_); }
  [[nodiscard]] VirtualNetwork& network() { return wire; }
  [[nodiscard]] Emulator& emulator() { return emulator_; }
  /// The driver does not run: a process that is stopped.
  bool frozen = false;

 private:
  void advance(Nanoseconds now);
  void serve();

  Nanoseconds core_period_;
  Endpoint remote_;
  Emulator emulator_;
  std::int64_t core_cycle_ = -1;
  emulation::StateHash state_;
};

}  // namespace takt::hw::wsg
