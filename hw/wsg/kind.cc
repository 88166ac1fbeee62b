// The kind of back end "wsg": its settings, and what is made of them.
#include <cmath>

#include <fmt/format.h>

#include "hw/drivers.h"
#include "hw/wire/settings_rows.h"
#include "hw/wsg/twin.h"

namespace takt::hw::wsg {
namespace {

using device::DriverSettings;
using device::GripperDescription;
using device::GripperRequest;

struct WsgSettings final : DriverSettings {
  TwinOptions options;
  Nanoseconds update = 0;  ///< 0: that of the gripper's model
};

Form settings_form() {
  return {
      .doc = "A gripper of the WSG series (docs/hardware-devices.md).",
      .keys = {address_key("an emulated gripper", "HOST[:PORT]: the gripper."), emulated_key(),
               whole_ms_key("update_ms", 0, {.low = 0, .high = 100},
                            "Period of the gripper's automatic updates; 0: the cycle of the model."),
               boolean_key("home", "References fingers that are not: they open as far as they can.").by_default(false),
               boolean_key("referenced", "The emulated fingers were homed before.").by_default(true),
               transport_key(0.1, 10.0, "message"), jitter_key(0.0, 10.0), piece_key()}};
}

VirtualFaults read_wire(FormReader& from) {
  VirtualFaults faults;
  faults.wire.transport = read_ms(from, "transport_ms");
  faults.wire.jitter = read_ms(from, "jitter_ms");
  faults.stream_piece = static_cast<std::size_t>(from.integer("piece_bytes"));
  return faults;
}

/// A gripper alone at its port, with the sockets that it listens on.
class SocketEmulator final : public device::ControllerEmulator {
 public:
  SocketEmulator(const EmulatorOptions& options, const GripperRequest& request,
                 std::shared_ptr<device::GripperBackend> machine)
      : emulator_(options, request.description, network_, std::move(machine)) {}
  [[nodiscard]] Result<void> listen(const Endpoint& local) { return emulator_.listen(local); }
  void advance(Nanoseconds now) override { emulator_.advance(now); }
  [[nodiscard]] std::vector<std::string> news() override { return emulator_.news(); }

 private:
  PosixNetwork network_;
  Emulator emulator_;
};

class WsgKind final : public device::GripperDriverKind {
 public:
  WsgKind()
      : GripperDriverKind("wsg", "grippers of the WSG series (Schunk, Weiss Robotics): binary commands on TCP",
                          settings_form()) {}

  [[nodiscard]] std::shared_ptr<const DriverSettings> read(FormReader& from) const override {
    auto settings = std::make_shared<WsgSettings>();
    settings->address = from.text("address");
    ClientOptions& client = settings->options.client;
    if (!settings->in_process()) {
      const auto endpoint = parse_endpoint(settings->address, kPort);
      if (endpoint) client.remote = *endpoint;
      if (!endpoint) from.diagnostics().append(endpoint.error(), from.at("address"));
    }
    settings->emulated_peer = from.boolean("emulated", client.remote.is_loopback());
    settings->update = read_ms(from, "update_ms");
    client.home = from.boolean("home");
    settings->options.emulator.referenced = from.boolean("referenced");
    settings->options.faults = read_wire(from);
    client.transport = settings->in_process() ? settings->options.faults.wire.transport : 0;
    return settings;
  }

  [[nodiscard]] std::string refuse(const DriverSettings& settings, const GripperDescription& gripper) const override {
    const Nanoseconds period = cycle(settings, gripper);
    if (period < kMillisecond || period % kMillisecond != 0)
      return fmt::format("its updates come each {:g} ms, but whole milliseconds are sent: update_ms",
                         static_cast<double>(period) / kMillisecond);
    return {};
  }
  [[nodiscard]] Nanoseconds cycle(const DriverSettings& settings, const GripperDescription& gripper) const override {
    return own(settings).update > 0 ? own(settings).update : gripper.cycle;
  }
  [[nodiscard]] Result<std::shared_ptr<device::GripperDriver>> connect(const DriverSettings& settings,
                                                                       const GripperRequest& request,
                                                                       const Clock& clock) const override {
    return std::make_shared<Driver>(options_for(settings, request).client, request, clock);
  }
  [[nodiscard]] Result<std::shared_ptr<device::GripperDriver>> connect_in_process(
      const DriverSettings& settings, const GripperRequest& request,
      std::shared_ptr<device::GripperBackend> machine) const override {
    auto twin = std::make_shared<Twin>(request, options_for(settings, request), std::move(machine));
    if (auto begun = twin->begin(); !begun) return std::unexpected(begun.error());
    return twin;
  }
  [[nodiscard]] Result<std::unique_ptr<device::ControllerEmulator>> emulate(
      const DriverSettings& settings, const GripperRequest& request,
      std::shared_ptr<device::GripperBackend> machine) const override {
    auto emulator = std::make_unique<SocketEmulator>(own(settings).options.emulator, request, std::move(machine));
    if (auto begun = emulator->listen(own(settings).options.client.remote); !begun)
      return std::unexpected(begun.error());
    return emulator;
  }

 private:
  static const WsgSettings& own(const DriverSettings& settings) { return dynamic_cast<const WsgSettings&>(settings); }
  [[nodiscard]] TwinOptions options_for(const DriverSettings& settings, const GripperRequest& request) const {
    TwinOptions options = own(settings).options;
    options.client.update = cycle(settings, *request.description);
    return options;
  }
};

}  // namespace
}  // namespace takt::hw::wsg

namespace takt::hw {

std::unique_ptr<device::DriverKind> wsg_kind() { return std::make_unique<wsg::WsgKind>(); }

}  // namespace takt::hw
