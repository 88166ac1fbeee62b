// The driver kind "rtde", as site files and --backend name it.
#include <filesystem>
#include <thread>

#include <fmt/format.h>

#include "core/base/json.h"
#include "hw/drivers.h"
#include "hw/emulators/rtde/emulated_robot.h"
#include "hw/rtde/driver.h"
#include "hw/rtde/kind/lock_step_robot.h"
#include "hw/wire/posix_network.h"
#include "hw/wire/settings_rows.h"

namespace takt::hw::rtde {

namespace {

constexpr double kSocketMargin = 4.0;                  // ms, for what wire, threads and core are late
constexpr int kThreadPriority = 85;                    // of SCHED_FIFO, where permitted
constexpr Nanoseconds kLookAround = 2 * kMillisecond;  // longest time between two looks of the driver's thread

struct RtdeSettings final : device::DriverSettings {
  DriverOptions driver;
  ControllerOptions controller;
  hw::VirtualFaults faults;
};

const RtdeSettings& own(const device::DriverSettings& settings) { return static_cast<const RtdeSettings&>(settings); }

/// What a thread of a driver needs before the driver is made.
struct OwnNetwork {
  hw::PosixNetwork posix;
};

/// The driver on the machine's sockets, with its thread.
class SocketDriver final : private OwnNetwork, public Driver {
 public:
  SocketDriver(const DriverOptions& options, const device::DriverRequest& request, const Clock& clock)
      : Driver(options, request, posix, clock), thread_([this](const std::stop_token& stop) { serve(stop); }) {}
  ~SocketDriver() override {
    thread_.request_stop();
    thread_.join();
  }
  SocketDriver(const SocketDriver&) = delete;
  SocketDriver& operator=(const SocketDriver&) = delete;

 private:
  void serve(const std::stop_token& stop) {
    const sched_param parameters{.sched_priority = kThreadPriority};
    (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);  // refused: it runs without
    while (!stop.stop_requested()) {
      poll();
      wait(kLookAround);
    }
  }

  std::jthread thread_;
};

/// The controller's side alone, on the machine's sockets.
class SocketEmulator final : public device::ControllerEmulator {
 public:
  SocketEmulator(const RtdeSettings& settings, const device::DriverRequest& request,
                 std::shared_ptr<device::ArmBackend> machine)
      : period_(request.core_period),
        block_(request.terminals),
        robot_(settings.controller, request.description, std::move(machine), network_) {}
  [[nodiscard]] Result<void> listen(std::uint32_t host) { return robot_.listen(host); }

  void advance(Nanoseconds now) override { robot_.step(now / period_, now); }
  void set_brakes(std::function<void()> close, std::function<void()> open) override {
    robot_.close_brakes = std::move(close);
    robot_.open_brakes = std::move(open);
  }
  void set_terminals(const device::IoTerminals& machine) override {
    if (block_ != nullptr) robot_.set_terminals(*block_, machine);
  }
  [[nodiscard]] std::vector<std::string> news() override {
    std::vector<std::string> lines;
    const EventLog& events = robot_.controller().events();
    for (next_event_ = std::max(next_event_, events.begin()); next_event_ < events.end(); ++next_event_) {
      const ControllerEvent& event = events[next_event_];
      lines.push_back(event.title.empty() ? event.text : event.title + " " + event.text);
    }
    return lines;
  }

 private:
  Nanoseconds period_;
  std::shared_ptr<const device::IoDescription> block_;
  hw::PosixNetwork network_;
  EmulatedRobot robot_;
  std::uint64_t next_event_ = 0;
};

Form settings_form() {
  return {
      .doc = "A robot of Universal Robots (docs/hardware-ur.md).",
      .keys = {
          address_key("an emulated controller", "HOST: the controller."), emulated_key(),
          choice_key("series", {"cb3", "e"}, "e: an e-Series, 500 Hz.").by_default("cb3"),
          text_key("robot", "Begin of what the controller must answer to 'get robot model'.").by_default("UR5"),
          choice_key("registers", {"upper", "lower"}, "lower: another client has the upper half.").by_default("upper"),
          number_key("lookahead_s", "s", {.low = 0.03, .high = 0.2}, "Of servoj().").by_default(0.03),
          text_key("programs",
                   "Of an emulated controller: a folder with the scripts that PolyScope saves beside its programs. "
                   "NAME.script is what the dashboard loads as NAME.urp.")
              .optional("none"),
          text_key("external_control",
                   "Of an emulated controller: the client that the program external_control.urp asks for its text. "
                   "Port 50002 where none is given.")
              .optional("it is not installed"),
          boolean_key("remote_control",
                      "Of an emulated e-Series: what it answers to 'is in remote control'; only then it accepts "
                      "scripts and play.")
              .by_default(true),
          number_key("gain", "", {.low = 100.0, .high = 2000.0}, "Of servoj().").by_default(2000.0),
          boolean_key("power_on", "Powers on and releases the brakes when it connects.").by_default(false),
          margin_key("wire and core"), transport_key(0.1, 10.0, "message"), jitter_key(0.3, 10.0)}};
}

class RtdeKind final : public device::ArmDriverKind {
 public:
  RtdeKind() : ArmDriverKind("rtde", "Universal Robots CB3 and e-Series over RTDE", settings_form()) {}

  std::shared_ptr<const device::DriverSettings> read(FormReader& from) const override;
  std::string refuse(const device::DriverSettings& settings, const device::ArmDescription& arm) const override;
  std::string refuse_terminals(const device::IoDescription& io) const override { return rtde::refuse_terminals(io); }
  Nanoseconds cycle(const device::DriverSettings& settings, const device::ArmDescription&) const override {
    return own(settings).driver.cycle();
  }
  Nanoseconds delay(const device::DriverSettings& settings, const device::ArmDescription& arm,
                    Nanoseconds core_period) const override;
  Result<std::shared_ptr<device::ArmDriver>> connect(const device::DriverSettings& settings,
                                                     const device::DriverRequest& request,
                                                     const Clock& clock) const override {
    return std::make_shared<SocketDriver>(own(settings).driver, request, clock);
  }
  Result<std::shared_ptr<device::ArmDriver>> connect_in_process(
      const device::DriverSettings& settings, const device::DriverRequest& request,
      std::shared_ptr<device::ArmBackend> machine) const override;
  Result<std::unique_ptr<device::ControllerEmulator>> emulate(
      const device::DriverSettings& settings, const device::DriverRequest& request,
      std::shared_ptr<device::ArmBackend> machine) const override;

 private:
  static void read_address(FormReader& from, RtdeSettings& settings);
  static void read_wire(FormReader& from, RtdeSettings& settings);
  static void read_installation(FormReader& from, RtdeSettings& settings);
};

void RtdeKind::read_address(FormReader& from, RtdeSettings& settings) {
  settings.address = from.text("address");
  if (settings.in_process()) return;
  const auto endpoint = hw::parse_endpoint(settings.address, kRtdePort);
  if (!endpoint) {
    from.diagnostics().append(endpoint.error(), from.at("address"));
  } else if (endpoint->port != kRtdePort) {
    from.diagnostics().error(Code::kUnsupported, from.at("address"), fmt::format("port {}", endpoint->port),
                             "Give its address alone: the ports of a UR controller are fixed");
  } else {
    settings.driver.host = endpoint->host;
  }
}

void RtdeKind::read_wire(FormReader& from, RtdeSettings& settings) {
  settings.faults.wire.jitter = read_ms(from, "jitter_ms");
  settings.faults.wire.transport = read_ms(from, "transport_ms");
  const double jitter_ms = static_cast<double>(settings.faults.wire.jitter) / kMillisecond;
  settings.driver.margin = read_ms(from, "margin_ms", settings.in_process() ? jitter_ms : kSocketMargin);
  settings.driver.transport = settings.faults.wire.transport;
}

/// What is installed on an emulated controller: programs by their names, and scripts as PolyScope saves them beside.
void RtdeKind::read_installation(FormReader& from, RtdeSettings& settings) {
  ControllerOptions& controller = settings.controller;
  controller.remote_control = from.boolean("remote_control");
  if (!controller.remote_control && !settings.driver.e_series) {
    from.diagnostics().error(Code::kIncompatible, from.at("remote_control"), "a CB3 has no remote control",
                             "Add series=e, or remove remote_control");
  }
  if (const std::string client = from.text("external_control"); !client.empty()) {
    constexpr std::uint16_t kExternalControlPort = 50002;
    const auto endpoint = hw::parse_endpoint(client, kExternalControlPort);
    if (endpoint) {
      controller.external_control = *endpoint;
    } else {
      from.diagnostics().append(endpoint.error(), from.at("external_control"));
    }
  }
  const std::string folder = from.text("programs");
  if (folder.empty()) return;
  constexpr std::size_t kLongest = 1u << 20;
  std::error_code failed;
  for (const auto& file : std::filesystem::directory_iterator(folder, failed)) {
    if (file.path().extension() != ".script") continue;
    auto text = read_file(file.path(), kLongest);
    if (!text) {
      from.diagnostics().append(text.error(), from.at("programs"));
      continue;
    }
    controller.programs[fmt::format("/programs/{}.urp", file.path().stem().string())] = std::move(*text);
  }
  if (failed || controller.programs.empty()) {
    from.diagnostics().error(
        failed ? Code::kFileNotReadable : Code::kNotFound, from.at("programs"),
        failed ? fmt::format("'{}': {}", folder, failed.message()) : fmt::format("'{}' has no .script", folder),
        "Name a folder with the scripts that PolyScope saves beside its programs: NAME.script for NAME.urp");
  }
}

std::shared_ptr<const device::DriverSettings> RtdeKind::read(FormReader& from) const {
  auto settings = std::make_shared<RtdeSettings>();
  read_address(from, *settings);
  DriverOptions& driver = settings->driver;
  driver.e_series = from.choice("series") == "e";
  driver.model = from.text("robot");
  driver.registers = from.choice("registers") == "upper" ? RegisterHalf::kUpper : RegisterHalf::kLower;
  driver.lookahead = from.number("lookahead_s");
  driver.gain = from.number("gain");
  driver.power_on = from.boolean("power_on");
  settings->emulated_peer = from.boolean("emulated", hw::Endpoint{driver.host, 0}.is_loopback());
  read_wire(from, *settings);
  read_installation(from, *settings);
  if (driver.e_series) {
    settings->controller.version = {5, 12, 2, 1101534};
    settings->controller.model = "UR5e";
  }
  return settings;
}

std::string RtdeKind::refuse(const device::DriverSettings&, const device::ArmDescription& arm) const {
  if (arm.joint_names.size() != 6)
    return fmt::format("a UR robot has six joints, this arm has {}", arm.joint_names.size());
  if (!arm.modes.has(device::ControlMode::kPosition))
    return "RTDE drives an arm in mode position, which this one lacks";
  return {};
}

Nanoseconds RtdeKind::delay(const device::DriverSettings& settings, const device::ArmDescription&,
                            Nanoseconds core_period) const {
  const DriverOptions& driver = own(settings).driver;
  return core_period + driver.margin + kLeadCycles * driver.cycle();
}

Result<std::shared_ptr<device::ArmDriver>> RtdeKind::connect_in_process(
    const device::DriverSettings& settings, const device::DriverRequest& request,
    std::shared_ptr<device::ArmBackend> machine) const {
  const RtdeSettings& rtde = own(settings);
  auto robot = std::make_shared<LockStepRobot>(rtde.driver, rtde.controller, request, std::move(machine), rtde.faults);
  if (auto begun = robot->begin(); !begun) return std::unexpected(begun.error());
  return robot;
}

Result<std::unique_ptr<device::ControllerEmulator>> RtdeKind::emulate(
    const device::DriverSettings& settings, const device::DriverRequest& request,
    std::shared_ptr<device::ArmBackend> machine) const {
  const RtdeSettings& rtde = own(settings);
  auto emulator = std::make_unique<SocketEmulator>(rtde, request, std::move(machine));
  if (auto listening = emulator->listen(rtde.driver.host); !listening) return std::unexpected(listening.error());
  return emulator;
}

}  // namespace

}  // namespace takt::hw::rtde

namespace takt::hw {

std::unique_ptr<device::DriverKind> rtde_kind() { return std::make_unique<rtde::RtdeKind>(); }

}  // namespace takt::hw
