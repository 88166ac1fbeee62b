// The kind of back end "cia402": its settings, and what is made of them.
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "hw/can/datagram_can.h"
#include "hw/can/socket_can.h"
#include "hw/cia402/twin.h"
#include "hw/drivers.h"
#include "hw/wire/posix_network.h"
#include "hw/wire/settings_rows.h"

namespace takt::hw::cia402 {
namespace {

using device::DriverRequest;
using device::DriverSettings;

struct Cia402Settings final : DriverSettings {
  std::optional<Endpoint> endpoint;  ///< frames in datagrams; none: `address` is a CAN interface
  TwinOptions options;
  Nanoseconds cycle = 0;  ///< of the bus; 0: that of the arm's model
};

Form settings_form() {
  return {.doc = "An arm of drives of CiA 402 on CANopen (docs/hardware-cia402.md).",
          .keys = {
              address_key("emulated drives", "A CAN interface, such as can0. HOST[:PORT]: frames in datagrams."),
              emulated_key(), whole_ms_key("cycle_ms", 0, {.low = 0, .high = 100}, "Of the bus; 0: that of the model."),
              integer_key("first_node", {.low = 1, .high = 126}, "Node of the first joint; the others follow.")
                  .by_default(1.0),
              whole_ms_key("heartbeat_ms", 50, {.low = 10, .high = 1000}, "Of both sides; who misses three is lost."),
              margin_key("bus and core"),
              integer_key("bridged_cycles", {.low = 1, .high = 100},
                          "With one more without SYNC or set point an emulated drive stops by itself.")
                  .by_default(3.0),
              // Inputs of one cycle have to be there before the next one begins.
              transport_key(0.05, 0.2, "frame"), jitter_key(0.0, 0.2), share_key("loss", "do not arrive")}};
}

/// "virtual", "can0", or where frames in datagrams meet: the drives' end.
void read_address(FormReader& from, Cia402Settings& settings) {
  settings.address = from.text("address");
  const bool interface = is_interface_name(settings.address) && settings.address != "localhost";
  if (settings.in_process() || interface) return;
  const auto endpoint = parse_endpoint(settings.address, kCanPort);
  if (!endpoint) {
    from.diagnostics().append(endpoint.error(), from.at("address"));
    return;
  }
  settings.endpoint = *endpoint;
}

VirtualFaults read_faults(FormReader& from) {
  VirtualFaults faults;
  faults.wire.transport = read_ms(from, "transport_ms");
  faults.wire.jitter = read_ms(from, "jitter_ms");
  faults.wire.loss = from.number("loss");
  return faults;
}

class Cia402Kind final : public device::ArmDriverKind {
 public:
  Cia402Kind()
      : ArmDriverKind("cia402", "drives of CiA 402 on CANopen: position mode, this side sets the pace",
                      settings_form()) {}

  [[nodiscard]] std::shared_ptr<const DriverSettings> read(FormReader& from) const override {
    auto settings = std::make_shared<Cia402Settings>();
    TwinOptions& options = settings->options;
    read_address(from, *settings);
    settings->emulated_peer = from.boolean("emulated", settings->endpoint && settings->endpoint->is_loopback());
    settings->cycle = read_ms(from, "cycle_ms");
    options.bus.first_node = static_cast<NodeId>(from.integer("first_node"));
    options.bus.heartbeat = read_ms(from, "heartbeat_ms");
    options.emulator = {.first_node = options.bus.first_node,
                        .bridged = static_cast<int>(from.integer("bridged_cycles"))};
    options.faults = read_faults(from);
    const double jitter_ms = static_cast<double>(options.faults.wire.jitter) / kMillisecond;
    // Without a real-time kernel threads wake up late by milliseconds.
    options.client.margin = read_ms(from, "margin_ms", settings->in_process() ? jitter_ms : 4.0);
    return settings;
  }

  [[nodiscard]] std::string refuse(const DriverSettings& settings, const device::ArmDescription& arm) const override {
    const auto joints = static_cast<int>(arm.joint_names.size());
    const int first = own(settings).options.bus.first_node;
    if (first + joints > kMasterNode)
      return fmt::format("{} drives from node {} on: the last would be {}, the most is {}", joints, first,
                         first + joints - 1, kMasterNode - 1);
    if (!arm.modes.has(device::ControlMode::kPosition)) return "it has no mode position, which is what CSP is";
    const Nanoseconds period = cycle(settings, arm);
    if (period % kMillisecond != 0) return "the cycle of the bus has to be whole milliseconds: cycle_ms";
    return {};
  }
  /// Drives lock to SYNC, which this side sends.
  [[nodiscard]] bool paces() const override { return false; }
  [[nodiscard]] Nanoseconds cycle(const DriverSettings& settings, const device::ArmDescription& arm) const override {
    return own(settings).cycle > 0 ? own(settings).cycle : arm.cycle;
  }
  [[nodiscard]] Nanoseconds delay(const DriverSettings& settings, const device::ArmDescription& arm,
                                  Nanoseconds core_period) const override {
    return options_for(settings, arm).client.timing(core_period, 0).delay();
  }

  [[nodiscard]] Result<std::shared_ptr<device::ArmDriver>> connect(const DriverSettings& settings,
                                                                   const DriverRequest& request,
                                                                   const Clock& clock) const override {
    const TwinOptions options = options_for(settings, *request.description);
    const auto& endpoint = own(settings).endpoint;
    auto link = open(settings, endpoint ? Endpoint{endpoint->is_loopback() ? kLoopback : 0, 0} : Endpoint{},
                     endpoint.value_or(Endpoint{}), clock);
    if (!link) return std::unexpected(link.error());
    auto bus = std::make_unique<CanopenBus>(*request.description, options.bus, std::move(*link));
    return std::make_shared<Driver>(request, options.client, std::move(bus), clock);
  }
  [[nodiscard]] Result<std::shared_ptr<device::ArmDriver>> connect_in_process(
      const DriverSettings& settings, const DriverRequest& request,
      std::shared_ptr<device::ArmBackend> machine) const override {
    return std::make_shared<Twin>(request, options_for(settings, *request.description), std::move(machine));
  }
  [[nodiscard]] Result<std::unique_ptr<device::ControllerEmulator>> emulate(
      const DriverSettings& settings, const DriverRequest& request,
      std::shared_ptr<device::ArmBackend> machine) const override {
    static const MonotonicClock clock;
    auto link = open(settings, own(settings).endpoint.value_or(Endpoint{}), {}, clock);
    if (!link) return std::unexpected(link.error());
    return std::make_unique<Emulator>(request, own(settings).options.emulator, std::move(*link), std::move(machine));
  }

 private:
  /// What read() made.
  static const Cia402Settings& own(const DriverSettings& settings) {
    return dynamic_cast<const Cia402Settings&>(settings);
  }
  [[nodiscard]] TwinOptions options_for(const DriverSettings& settings, const device::ArmDescription& arm) const {
    TwinOptions options = own(settings).options;
    options.client.cycle = options.bus.cycle = cycle(settings, arm);
    return options;
  }
  static Result<std::unique_ptr<CanLink>> open(const DriverSettings& settings, const Endpoint& local,
                                               const Endpoint& peer, const Clock& clock) {
    if (!own(settings).endpoint) return open_socket_can(settings.address);
    auto datagrams = PosixNetwork().open_datagrams(local);
    if (!datagrams) return std::unexpected(datagrams.error());
    return std::make_unique<DatagramCan>(std::move(*datagrams), peer, clock);
  }
};

}  // namespace
}  // namespace takt::hw::cia402

namespace takt::hw {

std::unique_ptr<device::DriverKind> cia402_kind() { return std::make_unique<cia402::Cia402Kind>(); }

}  // namespace takt::hw
