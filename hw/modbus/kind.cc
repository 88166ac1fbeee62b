// The kind of back end "modbus": its settings, and what is made of them.
#include <cmath>

#include <fmt/format.h>

#include "hw/drivers.h"
#include "hw/modbus/twin.h"

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

Nanoseconds ns_from_ms(double ms) { return static_cast<Nanoseconds>(std::llround(ms * kMillisecond)); }

MapOptions read_map(ObjectReader& reader) {
  const auto address = [&](const char* key) {
    return static_cast<std::uint16_t>(reader.integer(key, 0, {.low = 0, .high = 65'535}));
  };
  MapOptions map;
  map.digital_inputs = address("digital_inputs");
  map.digital_outputs = address("digital_outputs");
  map.analog_inputs = address("analog_inputs");
  map.analog_outputs = address("analog_outputs");
  map.counts = static_cast<std::uint16_t>(reader.integer("analog_counts", 32'767, {.low = 1, .high = 65'535}));
  map.unit = static_cast<std::uint8_t>(reader.integer("unit", 1, {.low = 0, .high = 255}));
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
  ModbusKind() : IoDriverKind("modbus", "I/O blocks behind a coupler on Modbus TCP") {}

  [[nodiscard]] std::shared_ptr<const DriverSettings> read(ObjectReader& reader) const override {
    auto settings = std::make_shared<ModbusSettings>();
    TwinOptions& options = settings->options;
    settings->address = reader.text("address", "virtual");
    if (!settings->in_process()) {
      const auto endpoint = parse_endpoint(settings->address, kPort);
      if (endpoint) options.client.remote = *endpoint;
      if (!endpoint) reader.diagnostics().append(endpoint.error(), reader.at("address"));
    }
    settings->emulated_peer = reader.boolean("emulated", options.client.remote.is_loopback());
    options.client.map = options.coupler.map = read_map(reader);
    options.client.cycle = reader.integer("cycle_ms", 10, {.low = 1, .high = 1000}) * kMillisecond;
    options.client.timeout = reader.integer("timeout_ms", 200, {.low = 10, .high = 10'000}) * kMillisecond;
    options.coupler.watchdog = reader.integer("watchdog_ms", 1000, {.low = 0, .high = 60'000}) * kMillisecond;
    options.faults.wire.transport = ns_from_ms(reader.number("transport_ms", 0.1, {.low = 0.0, .high = 10.0}));
    options.faults.wire.jitter = ns_from_ms(reader.number("jitter_ms", 0.0, {.low = 0.0, .high = 10.0}));
    options.faults.stream_piece = static_cast<std::size_t>(reader.integer("piece_bytes", 0, {.low = 0, .high = 1500}));
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
