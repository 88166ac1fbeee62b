// The kind of back end "modbus": its settings, and what is made of them.
#include <cmath>

#include <fmt/format.h>

#include "hw/drivers.h"
#include "hw/modbus/twin.h"
#include "hw/wire/settings_rows.h"

namespace takt::hw::modbus {
namespace {

using device::DriverSettings;
using device::IoDescription;
using device::IoRequest;
using device::IoTerminals;

struct ModbusSettings final : DriverSettings {
  TwinOptions options;
};

const ModbusSettings& own_settings(const DriverSettings& settings) {
  return dynamic_cast<const ModbusSettings&>(settings);
}

Form settings_form() {
  const auto first = [](const char* name) {
    return integer_key(name, {.low = 0, .high = 65'535},
                       "Address of the first terminal of this kind; the others follow.")
        .by_default(0.0);
  };
  return {
      .doc = "An I/O block behind a coupler on Modbus TCP (docs/hardware-devices.md).",
      .keys = {address_key("an emulated coupler", "HOST[:PORT]: the coupler."), emulated_key(),
               whole_ms_key("cycle_ms", 10, {.low = 1, .high = 1000}, "From one exchange to the next."),
               first("digital_inputs"), first("digital_outputs"), first("analog_inputs"), first("analog_outputs"),
               integer_key("analog_counts", {.low = 1, .high = 65'535}, "Register value of the upper end of a range.")
                   .by_default(32'767.0),
               integer_key("unit", {.low = 0, .high = 255}, "Unit identifier.").by_default(1.0),
               whole_ms_key("timeout_ms", 200, {.low = 10, .high = 10'000}, "For an answer."),
               whole_ms_key("watchdog_ms", 1000, {.low = 0, .high = 60'000},
                            "Without a request for so long the emulated coupler switches its outputs off; 0: "
                            "never."),
               transport_key(0.1, 10.0, "message"), jitter_key(0.0, 10.0), piece_key()}};
}

MapOptions read_map(FormReader& from) {
  const auto number = [&]<class T>(const char* key, T& to) { to = static_cast<T>(from.integer(key)); };
  MapOptions map;
  number("digital_inputs", map.digital_inputs);
  number("digital_outputs", map.digital_outputs);
  number("analog_inputs", map.analog_inputs);
  number("analog_outputs", map.analog_outputs);
  number("analog_counts", map.counts);
  number("unit", map.unit);
  return map;
}

/// A coupler alone at its port, with the sockets that it listens on.
class SocketCoupler final : public device::ControllerEmulator {
 public:
  SocketCoupler(const CouplerOptions& options, const IoRequest& request, const IoTerminals& machine)
      : coupler_(options, request.description, network_, machine) {}
  [[nodiscard]] Result<void> listen(const Endpoint& local) { return coupler_.listen(local); }
  void advance(Nanoseconds now) override { coupler_.advance(now); }
  [[nodiscard]] std::vector<std::string> news() override { return coupler_.news(); }

 private:
  PosixNetwork network_;
  Coupler coupler_;
};

class ModbusKind final : public device::IoDriverKind {
 public:
  ModbusKind() : IoDriverKind("modbus", "I/O blocks behind a coupler on Modbus TCP", settings_form()) {}

  [[nodiscard]] std::shared_ptr<const DriverSettings> read(FormReader& from) const override {
    auto settings = std::make_shared<ModbusSettings>();
    TwinOptions& options = settings->options;
    settings->address = from.text("address");
    if (!settings->in_process()) {
      const auto endpoint = parse_endpoint(settings->address, kPort);
      if (endpoint) options.client.remote = *endpoint;
      if (!endpoint) from.diagnostics().append(endpoint.error(), from.at("address"));
    }
    settings->emulated_peer = from.boolean("emulated", options.client.remote.is_loopback());
    options.client.map = options.coupler.map = read_map(from);
    options.client.cycle = read_ms(from, "cycle_ms");
    options.client.timeout = read_ms(from, "timeout_ms");
    options.coupler.watchdog = read_ms(from, "watchdog_ms");
    options.faults.wire.transport = read_ms(from, "transport_ms");
    options.faults.wire.jitter = read_ms(from, "jitter_ms");
    options.faults.stream_piece = static_cast<std::size_t>(from.integer("piece_bytes"));
    return settings;
  }

  [[nodiscard]] std::string refuse(const DriverSettings& settings, const IoDescription& io) const override {
    const TerminalMap map(own_settings(settings).options.client.map, io);
    constexpr int kLastAddress = 65'535;
    for (const auto kind : {device::IoChannel::Kind::kDigitalInput, device::IoChannel::Kind::kDigitalOutput,
                            device::IoChannel::Kind::kAnalogInput, device::IoChannel::Kind::kAnalogOutput}) {
      const std::size_t count = map.list(kind).size();
      if (count > kMostTerminals)
        return fmt::format("it has {} terminals of one kind; the most is {}", count, kMostTerminals);
      if (map.first(kind) + static_cast<int>(count) - 1 > kLastAddress)
        return fmt::format("{} terminals from address {} on: the last address is {}", count, map.first(kind),
                           kLastAddress);
    }
    return io.channels.empty() ? "it has no terminals" : "";
  }
  [[nodiscard]] Nanoseconds cycle(const DriverSettings& settings, const IoDescription&) const override {
    return own_settings(settings).options.client.cycle;
  }
  [[nodiscard]] Result<std::shared_ptr<device::IoDriver>> connect(const DriverSettings& settings,
                                                                  const IoRequest& request,
                                                                  const Clock& clock) const override {
    return std::make_shared<Driver>(own_settings(settings).options.client, request, clock);
  }
  [[nodiscard]] Result<std::shared_ptr<device::IoDriver>> connect_in_process(
      const DriverSettings& settings, const IoRequest& request, const IoTerminals& machine) const override {
    auto twin = std::make_shared<Twin>(request, own_settings(settings).options, machine);
    if (auto begun = twin->begin(); !begun) return std::unexpected(begun.error());
    return twin;
  }
  [[nodiscard]] Result<std::unique_ptr<device::ControllerEmulator>> emulate(const DriverSettings& settings,
                                                                            const IoRequest& request,
                                                                            const IoTerminals& machine) const override {
    const TwinOptions& options = own_settings(settings).options;
    auto coupler = std::make_unique<SocketCoupler>(options.coupler, request, machine);
    if (auto begun = coupler->listen(options.client.remote); !begun) return std::unexpected(begun.error());
    return coupler;
  }
};

}  // namespace
}  // namespace takt::hw::modbus

namespace takt::hw {

std::unique_ptr<device::DriverKind> modbus_kind() { return std::make_unique<modbus::ModbusKind>(); }

}  // namespace takt::hw
