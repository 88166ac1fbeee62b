#pragma once

#include <memory>

#include "core/base/clock.h"
#include "core/emulation/state_hash.h"
#include "hw/cia402/canopen_bus.h"
#include "hw/cia402/driver.h"
#include "hw/emulators/cia402/emulator.h"
#include "hw/wire/virtual_network.h"

namespace takt::hw::cia402 {

/// How a twin differs from an arm that lives in the core's cycle.
struct TwinOptions {
  ClientOptions client;
  BusOptions bus;
  EmulatorOptions emulator;
  VirtualFaults faults;
};

/// What a twin is made of, in the order in which it has to be made.
struct TwinParts {
  TwinParts(std::uint64_t seed, const VirtualFaults& faults) : network(clock, seed, faults) {}
  VirtualClock clock;
  VirtualNetwork network;
};

/// The driver and the emulated drives on a virtual bus, around an arm that lives in the core's cycle, in lock-step:
/// read() makes time go on by one core cycle, so it is called once in each. The same seed gives the same bits.
/// Realtime: cyclic but for the constructor, the set-up of the drives, and news().
class Twin final : private TwinParts, public Backend {
 public:
  Twin(const device::DriverRequest& request, const TwinOptions& options, std::shared_ptr<device::ArmBackend> machine);

  bool read(device::ArmSample& sample) override;
  /// What the arm carries is entered at its own loops.
  void set_payload(const device::PayloadSetting& payload) override { machine_->set_payload(payload); }
  void set_tool(const device::ToolSetting& tool) override { machine_->set_tool(tool); }
  [[nodiscard]] std::vector<std::string> news() override;
  [[nodiscard]] std::span<const std::byte> state() const override { return state_.bytes(); }

  /// A core cycle in which the core does nothing: what a stalled core looks like to the arm.
  void pass_cycle() { advance(++core_cycle_ * core_period_); }
  /// One in which the driver does nothing either: killed, frozen.
  void pass_cycle_without_driver();
  [[nodiscard]] VirtualNetwork& wire() { return network; }
  [[nodiscard]] Emulator& emulator() { return emulator_; }

 private:
  void advance(Nanoseconds now);
  void hash_state();

  std::shared_ptr<device::ArmBackend> machine_;
  Emulator emulator_;
  std::int64_t core_cycle_ = -1;
  Nanoseconds next_cycle_ = 0;  // of the bus
  bool driver_lives_ = true;
  emulation::StateHash state_;
};

}  // namespace takt::hw::cia402
