#pragma once

#include <array>
#include <memory>

#include "core/device/driver.h"
#include "core/emulation/device_clock.h"
#include "hw/emulators/fri/controller.h"
#include "hw/wire/datagram_link.h"

namespace takt::hw::fri {

/// Datagrams that an emulator did not take for commands.
struct EmulatorCounts {
  std::uint64_t commands = 0;
  std::uint64_t strangers = 0;  ///< from another host than the remote side's
  std::uint64_t misread = 0;    ///< no commands of this version
};

/// A controller on a wire, around an arm that takes set points each cycle. It sends from the beginning, whether or not
/// somebody listens. An arm without a sample makes it silent. One thread. Realtime: cyclic but for the constructor.
class Emulator final : public device::ControllerEmulator {
 public:
  /// @param remote  where it sends to, and from which host it takes commands
  /// @param clock   of the controller, against the time that advance() is told
  Emulator(const device::DriverRequest& request, const ControllerOptions& options, std::unique_ptr<DatagramLink> link,
           const Endpoint& remote, std::shared_ptr<device::ArmBackend> machine,
           const emulation::DeviceClock& clock = {});

  void advance(Nanoseconds now) override;
  void set_tool(const device::ToolSetting& tool) override { controller_.set_tool(tool); }
  [[nodiscard]] std::vector<std::string> news() override { return controller_.news(); }

  // -- For who makes time go on in smaller steps (Twin). Times are the core's.
  /// When its next cycle begins.
  [[nodiscard]] Nanoseconds next_cycle() const { return clock_.to_core(cycle_ * options_.cycle); }
  /// Takes what has come.
  void receive(Nanoseconds now);
  /// Takes a datagram as if the remote side had sent it.
  void take(std::span<const std::byte> datagram, Nanoseconds now);
  /// Reads the arm: once in each cycle of the arm.
  void look();
  /// Leaves out a cycle in which the controller was off.
  void skip_cycle() { ++cycle_; }
  /// The next cycle begins; sends.
  void begin_cycle();
  /// Tells the arm where to be now.
  void drive(Nanoseconds now);

  [[nodiscard]] const Controller& controller() const { return controller_; }
  [[nodiscard]] const EmulatorCounts& counts() const { return counts_; }

 private:
  ControllerOptions options_;
  std::unique_ptr<DatagramLink> link_;
  Endpoint remote_;
  std::shared_ptr<device::ArmBackend> machine_;
  emulation::DeviceClock clock_;
  Controller controller_;
  EmulatorCounts counts_;
  std::int64_t cycle_;  // number of the next one, on its own clock
  std::int64_t driven_ = 0;
  device::ArmSample sample_;
  bool has_sample_ = false;
  std::array<std::byte, DatagramLink::kLargest> buffer_{};
};

}  // namespace takt::hw::fri
