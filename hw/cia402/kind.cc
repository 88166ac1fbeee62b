// The kind of back end "cia402": its settings, and what is made of them.
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "hw/can/datagram_can.h"
#include "hw/can/socket_can.h"
#include "hw/cia402/twin.h"
#include "hw/drivers.h"
#include "hw/wire/posix_network.h"

namespace takt::hw::cia402 {
namespace {

using device::DriverRequest;
using device::DriverSettings;

struct Cia402Settings final : DriverSettings {
  std::optional<Endpoint> endpoint;  ///< frames in datagrams; none: `address` is a CAN interface
  TwinOptions options;
  Nanoseconds cycle = 0;  ///< of the bus; 0: that of the arm's model
};

Nanoseconds from_ms(double ms) { return static_cast<Nanoseconds>(std::llround(ms * kMillisecond)); }

/// "virtual", "can0", or where frames in datagrams meet: the drives' end.
void read_address(ObjectReader& reader, Cia402Settings& settings) {
  settings.address = reader.text("address", "virtual");
  const bool interface = is_interface_name(settings.address) && settings.address != "localhost";
  if (settings.in_process() || interface) return;
  const auto endpoint = parse_endpoint(settings.address, kCanPort);
  if (!endpoint) {
    reader.diagnostics().append(endpoint.error(), reader.at("address"));
    return;
  }
  settings.endpoint = *endpoint;
}

VirtualFaults read_faults(ObjectReader& reader) {
  VirtualFaults faults;
  // Inputs of one cycle have to be there before the next one begins.
  faults.wire.transport = from_ms(reader.number("transport_ms", 0.05, {.low = 0.0, .high = 0.2}));
  faults.wire.jitter = from_ms(reader.number("jitter_ms", 0.0, {.low = 0.0, .high = 0.2}));
  faults.wire.loss = reader.number("loss", 0.0, {.low = 0.0, .high = 0.5});
  return faults;
}

class Cia402Kind final : public device::ArmDriverKind {
 public:
  Cia402Kind() : ArmDriverKind("cia402", "drives of CiA 402 on CANopen: position mode, this side sets the pace") {}

  [[nodiscard]] std::shared_ptr<const DriverSettings> read(ObjectReader& reader) const override {
    auto settings = std::make_shared<Cia402Settings>();
    TwinOptions& options = settings->options;
    read_address(reader, *settings);
    settings->emulated_peer = reader.boolean("emulated", settings->endpoint && settings->endpoint->is_loopback());
    settings->cycle = reader.integer("cycle_ms", 0, {.low = 0, .high = 100}) * kMillisecond;
    options.bus.first_node = static_cast<NodeId>(reader.integer("first_node", 1, {.low = 1, .high = 126}));
    options.bus.heartbeat = from_ms(static_cast<double>(reader.integer("heartbeat_ms", 50, {.low = 10, .high = 1000})));
    options.emulator = {.first_node = options.bus.first_node,
                        .bridged = static_cast<int>(reader.integer("bridged_cycles", 3, {.low = 1, .high = 100}))};
    options.faults = read_faults(reader);
    const double jitter_ms = static_cast<double>(options.faults.wire.jitter) / kMillisecond;
    // Without a real-time kernel threads wake up late by milliseconds.
    const double margin_ms = settings->in_process() ? jitter_ms : 4.0;
    options.client.margin = from_ms(reader.number("margin_ms", margin_ms, {.low = 0.0, .high = 100.0}));
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
