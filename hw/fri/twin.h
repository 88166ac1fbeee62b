#pragma once

#include <memory>

#include "core/base/clock.h"
#include "core/emulation/state_hash.h"
#include "hw/emulators/fri/emulator.h"
#include "hw/fri/driver.h"
#include "hw/wire/virtual_network.h"

namespace takt::hw::fri {

/// How a twin differs from an arm that lives in the core's cycle.
struct TwinOptions {
  ClientOptions client;
  ControllerOptions controller;
  VirtualFaults faults;
  Nanoseconds clock_offset = 0;  ///< the controller's clock shows this when the core's shows 0
  double drift = 0.0;            ///< s it gains per second
};

/// What a twin is made of, in the order in which it has to be made.
struct TwinParts {
  TwinParts(std::uint64_t seed, const VirtualFaults& faults) : network(clock, seed, faults) {}
  VirtualClock clock;
  VirtualNetwork network;
};

/// The driver and the emulated controller on a virtual wire, around an arm that lives in the core's cycle, in
/// lock-step: read() makes time go on by one core cycle, so it is called once in each. What runs is what runs on a
/// machine's network, but for sockets and threads. The same seed gives the same bits. Realtime: cyclic but for the
/// constructor and news().
class Twin final : private TwinParts, public Backend {
 public:
  static constexpr Endpoint kRemote{kLoopback, kPort};

  Twin(const device::DriverRequest& request, const TwinOptions& options, std::shared_ptr<device::ArmBackend> machine);

  bool read(device::ArmSample& sample) override;
  /// Settings do not travel on the wire: they are entered at the controller, too.
  void set_payload(const device::PayloadSetting& payload) override { machine_->set_payload(payload); }
  void set_tool(const device::ToolSetting& tool) override;
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override;
  [[nodiscard]] std::vector<std::string> news() override;
  [[nodiscard]] std::span<const std::byte> state() const override { return state_.bytes(); }

  /// A core cycle in which the core does nothing: what a stalled core looks like to the arm.
  void pass_cycle() { advance(++core_cycle_ * core_period_); }
  /// One in which the driver does nothing either: killed, frozen.
  void pass_cycle_without_driver();
  /// Bytes arrive at both ends in the name of the other one.
  void inject(std::span<const std::byte> to_driver, std::span<const std::byte> to_controller);
  [[nodiscard]] VirtualNetwork& wire() { return network; }
  [[nodiscard]] Emulator& emulator() { return *emulator_; }
  /// The controller is switched off and on: its counter, its clock and its KRL program begin anew.
  void restart_controller();

 private:
  void advance(Nanoseconds now);
  void make_emulator(Nanoseconds clock_offset);
  void hash_state();

  device::DriverRequest request_;
  TwinOptions options_;
  std::shared_ptr<device::ArmBackend> machine_;
  device::ToolSetting tool_;
  std::unique_ptr<Emulator> emulator_;
  std::int64_t core_cycle_ = -1;
  bool driver_lives_ = true;
  emulation::StateHash state_;
};

}  // namespace takt::hw::fri
