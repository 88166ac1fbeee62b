// The kind of back end "fri": its settings, and what is made of them.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "hw/drivers.h"
#include "hw/fri/twin.h"
#include "hw/wire/posix_network.h"
#include "hw/wire/settings_rows.h"

namespace takt::hw::fri {
namespace {

using device::DriverRequest;
using device::DriverSettings;

struct FriSettings final : DriverSettings {
  Endpoint endpoint{kLoopback, kPort};
  TwinOptions options;
};

Form settings_form() {
  return {.doc = "An arm of seven joints behind a driver of KUKA's FRI 1.0 (docs/hardware.md).",
          .keys = {address_key("an emulated controller",
                               "HOST[:PORT]: the controller, and the port on which this side listens."),
                   emulated_key(), whole_ms_key("cycle_ms", 1, {.low = 1, .high = 100}, "Of the interface."),
                   choice_key("krl", krl_conventions(),
                              "Convention of the KRL program; the last four are of the emulated controller alone.")
                       .by_default("takt"),
                   choice_key("task_frame", {"base", "tool"}, "$STIFFNESS.TASKFRAME.").by_default("base"),
                   margin_key("wire and core"),
                   integer_key("bridged_cycles", {.low = 1, .high = 1000},
                               "With so many answers missing in a row the emulated controller stops the arm.")
                       .by_default(20.0),
                   number_key("offset_ms", "ms", {.low = -1e9, .high = 1e9},
                              "What the controller's clock shows when the core's shows 0; virtual only.")
                       .by_default(0.0),
                   number_key("drift_ppm", "ppm", {.low = -500.0, .high = 500.0}, "How much it gains; virtual only.")
                       .by_default(0.0),
                   transport_key(0.05, 50.0, "datagram"), jitter_key(0.0, 50.0), share_key("loss", "do not arrive"),
                   share_key("repeat", "arrive twice"), share_key("reorder", "arrive after the next one"),
                   share_key("corrupt", "arrive with a wrong bit"), share_key("truncate", "arrive cut")}};
}

VirtualFaults read_faults(FormReader& from, Nanoseconds cycle) {
  VirtualFaults faults;
  faults.wire.transport = read_ms(from, "transport_ms");
  faults.wire.jitter = read_ms(from, "jitter_ms");
  faults.wire.loss = from.number("loss");
  faults.wire.repeat = from.number("repeat");
  faults.wire.reorder = from.number("reorder");
  faults.wire.hold_back = cycle + cycle / 2;
  faults.corrupt = from.number("corrupt");
  faults.truncate = from.number("truncate");
  return faults;
}

/// "virtual", or where driver and controller meet: HOST is the other end, PORT the one on which the remote side
/// listens.
void read_address(FormReader& from, FriSettings& settings) {
  settings.address = from.text("address");
  if (settings.in_process()) return;
  const auto endpoint = parse_endpoint(settings.address, kPort);
  if (!endpoint) {
    from.diagnostics().append(endpoint.error(), from.at("address"));
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
  FriKind() : ArmDriverKind("fri", "KUKA LWR 4+ over FRI 1.0: UDP, the controller sets the pace", settings_form()) {}

  [[nodiscard]] std::shared_ptr<const DriverSettings> read(FormReader& from) const override {
    auto settings = std::make_shared<FriSettings>();
    TwinOptions& options = settings->options;
    read_address(from, *settings);
    settings->emulated_peer = from.boolean("emulated", settings->endpoint.is_loopback());
    options.client.cycle = options.controller.cycle = read_ms(from, "cycle_ms");
    options.client.krl = options.controller.krl = from.choice("krl");
    options.client.task_frame_is_tool = options.controller.task_frame_is_tool = from.choice("task_frame") == "tool";
    options.client.controller = settings->in_process() ? 0 : settings->endpoint.host;
    options.faults = read_faults(from, options.client.cycle);
    const double jitter_ms = static_cast<double>(options.faults.wire.jitter) / kMillisecond;
    // Without a real-time kernel threads wake up late by milliseconds.
    options.client.margin = read_ms(from, "margin_ms", settings->in_process() ? jitter_ms : 4.0);
    options.clock_offset = read_ms(from, "offset_ms");
    options.drift = 1e-6 * from.number("drift_ppm");
    options.controller.bridged = static_cast<int>(from.integer("bridged_cycles"));
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
