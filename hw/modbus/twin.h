#pragma once

#include <memory>

#include "hw/emulators/modbus/coupler.h"
#include "hw/modbus/driver.h"
#include "hw/wire/virtual_network.h"

namespace takt::hw::modbus {

/// How a twin differs from a block that lives in the core's cycle.
struct TwinOptions {
  ClientOptions client;
  CouplerOptions coupler;
  VirtualFaults faults;
};

/// What a twin is made of, in the order in which it has to be made.
struct TwinParts {
  TwinParts(std::uint64_t seed, const VirtualFaults& faults) : wire(clock, seed, faults) {}
  VirtualClock clock;
  VirtualNetwork wire;
};

/// The driver and the emulated coupler in one process, in lock-step: time goes on by one core cycle when a terminal is
/// looked at for the second time. The same seed gives the same bits.
/// Realtime: cyclic but for the constructor, the set-up of a connection, and news().
class Twin final : private TwinParts, public Backend {
 public:
  Twin(const device::IoRequest& request, const TwinOptions& options, device::IoTerminals machine);
  /// Opens the coupler's port. Realtime: setup.
  [[nodiscard]] Result<void> begin() { return coupler_.listen(remote_); }

  [[nodiscard]] std::vector<std::string> news() override;
  [[nodiscard]] std::span<const std::byte> state() const override { return state_.bytes(); }

  /// A core cycle in which the core does nothing.
  void pass_cycle() { advance(++core_cycle_ * core_period_); }
  [[nodiscard]] VirtualNetwork& network() { return wire; }
  [[nodiscard]] Coupler& coupler() { return coupler_; }
  /// The driver does not run: a process that is stopped.
  bool frozen = false;

 private:
  void advance(Nanoseconds now);
  void serve(Nanoseconds now);

  Nanoseconds core_period_;
  Endpoint remote_;
  Coupler coupler_;
  std::int64_t core_cycle_ = -1;
  emulation::StateHash state_;
};

}  // namespace takt::hw::modbus
