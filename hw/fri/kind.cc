// The kind of back end "fri": its settings, and what is made of them.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "hw/drivers.h"
#include "hw/fri/twin.h"
#include "hw/wire/posix_network.h"

namespace takt::hw::fri {
namespace {

using device::DriverRequest;
using device::DriverSettings;

struct FriSettings final : DriverSettings {
  Endpoint endpoint{kLoopback, kPort};
  TwinOptions options;
};

Nanoseconds ns_of(double ms) { return static_cast<Nanoseconds>(std::llround(ms * kMillisecond)); }

VirtualFaults read_faults(ObjectReader& reader, Nanoseconds cycle) {
  constexpr Range kShare{.low = 0.0, .high = 0.5};
  VirtualFaults faults;
  faults.wire.transport = ns_of(reader.number("transport_ms", 0.05, {.low = 0.0, .high = 50.0}));
  faults.wire.jitter = ns_of(reader.number("jitter_ms", 0.0, {.low = 0.0, .high = 50.0}));
  faults.wire.loss = reader.number("loss", 0.0, kShare);
  faults.wire.repeat = reader.number("repeat", 0.0, kShare);
  faults.wire.reorder = reader.number("reorder", 0.0, kShare);
  faults.wire.hold_back = cycle + cycle / 2;
  faults.corrupt = reader.number("corrupt", 0.0, kShare);
  faults.truncate = reader.number("truncate", 0.0, kShare);
  return faults;
}

/// "virtual", or where driver and controller meet: HOST is the other end, PORT the one on which the remote side
/// listens.
void read_address(ObjectReader& reader, FriSettings& settings) {
  settings.address = reader.text("address", "virtual");
  if (settings.in_process()) return;
  const auto endpoint = parse_endpoint(settings.address, kPort);
  if (!endpoint) {
    reader.diagnostics().append(endpoint.error(), reader.at("address"));
    return;
  }
  settings.endpoint = *endpoint;
}

/// Some KRL programs are there for clients of others only. @return empty: the driver speaks with this one
Diagnostics refuse_convention(const std::string& krl) {
  Diagnostics diagnostics;
  if (std::ranges::find(driver_conventions(), krl) == driver_conventions().end()) {
    diagnostics.error(Code::kUnsupported, "/krl",
                      fmt::format("the driver does not speak with the KRL program '{}'", krl),
                      fmt::format("Load a program that speaks {}; 'takt emulate' knows the others",
                                  fmt::join(driver_conventions(), ", ")));
  }
  return diagnostics;
}

class FriKind final : public device::ArmDriverKind {
 public:
  FriKind() : ArmDriverKind("fri", "KUKA LWR 4+ over FRI 1.0: UDP, the controller sets the pace") {}

  [[nodiscard]] std::shared_ptr<const DriverSettings> read(ObjectReader& reader) const override {
    auto settings = std::make_shared<FriSettings>();
    TwinOptions& options = settings->options;
    read_address(reader, *settings);
    settings->emulated_peer = reader.boolean("emulated", settings->endpoint.is_loopback());
    const auto cycle_ms = reader.integer("cycle_ms", 1, {.low = 1, .high = 100});
    options.client.cycle = options.controller.cycle = cycle_ms * kMillisecond;
    options.client.krl = options.controller.krl = reader.choice("krl", krl_conventions(), "takt");
    const bool tool = reader.choice("task_frame", {"base", "tool"}, "base") == "tool";
    options.client.task_frame_is_tool = options.controller.task_frame_is_tool = tool;
    options.client.controller = settings->in_process() ? 0 : settings->endpoint.host;
    options.faults = read_faults(reader, options.client.cycle);
    const double jitter_ms = static_cast<double>(options.faults.wire.jitter) / kMillisecond;
    // Without a real-time kernel threads wake up late by milliseconds.
    const double margin_ms = settings->in_process() ? jitter_ms : 4.0;
    options.client.margin = ns_of(reader.number("margin_ms", margin_ms, {.low = 0.0, .high = 100.0}));
    options.clock_offset = ns_of(reader.number("offset_ms", 0.0, {.low = -1e9, .high = 1e9}));
    options.drift = 1e-6 * reader.number("drift_ppm", 0.0, {.low = -500.0, .high = 500.0});
    options.controller.bridged = static_cast<int>(reader.integer("bridged_cycles", 20, {.low = 1, .high = 1000}));
    return settings;
  }

  [[nodiscard]] std::string refuse(const DriverSettings&, const device::ArmDescription& arm) const override {
    const auto joints = arm.limits.velocity.size();
    if (joints == kJoints) return {};
    return fmt::format("FRI moves {} joints, '{}' has {}", kJoints, arm.model, joints);
  }
  [[nodiscard]] Nanoseconds cycle(const DriverSettings& settings, const device::ArmDescription&) const override {
    return own(settings).options.client.cycle;
  }
  [[nodiscard]] Nanoseconds delay(const DriverSettings& settings, const device::ArmDescription&,
                                  Nanoseconds core_period) const override {
    return own(settings).options.client.timing(core_period, 0).delay();
  }

  [[nodiscard]] Result<std::shared_ptr<device::ArmDriver>> connect(const DriverSettings& settings,
                                                                   const DriverRequest& request,
                                                                   const Clock& clock) const override {
    const FriSettings& fri = own(settings);
    if (auto refused = refuse_convention(fri.options.client.krl); !refused.empty()) return std::unexpected(refused);
    PosixNetwork network;
    auto link = network.open_datagrams({fri.endpoint.is_loopback() ? kLoopback : 0, fri.endpoint.port});
    if (!link) return std::unexpected(link.error());
    return std::make_shared<Driver>(request, fri.options.client, std::move(*link), clock);
  }
  [[nodiscard]] Result<std::shared_ptr<device::ArmDriver>> connect_in_process(
      const DriverSettings& settings, const DriverRequest& request,
      std::shared_ptr<device::ArmBackend> machine) const override {
    const TwinOptions& options = own(settings).options;
    if (auto refused = refuse_convention(options.client.krl); !refused.empty()) return std::unexpected(refused);
    return std::make_shared<Twin>(request, options, std::move(machine));
  }
  [[nodiscard]] Result<std::unique_ptr<device::ControllerEmulator>> emulate(
      const DriverSettings& settings, const DriverRequest& request,
      std::shared_ptr<device::ArmBackend> machine) const override {
    const FriSettings& fri = own(settings);
    PosixNetwork network;
    auto link = network.open_datagrams({fri.endpoint.is_loopback() ? kLoopback : 0, 0});
    if (!link) return std::unexpected(link.error());
    return std::make_unique<Emulator>(request, fri.options.controller, std::move(*link), fri.endpoint,
                                      std::move(machine));
  }

 private:
  /// What read() made.
  static const FriSettings& own(const DriverSettings& settings) { return dynamic_cast<const FriSettings&>(settings); }
};

}  // namespace
}  // namespace takt::hw::fri

namespace takt::hw {

std::unique_ptr<device::DriverKind> fri_kind() { return std::make_unique<fri::FriKind>(); }

}  // namespace takt::hw
