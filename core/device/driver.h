#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/clock.h"
#include "core/base/form.h"
#include "core/device/backend.h"
#include "core/device/description.h"
#include "core/device/gripper.h"
#include "core/device/sample_inlet.h"
#include "core/device/signal.h"

/// What stands between the canonical devices and the protocols of real controllers (docs/hardware.md). Protocols live
/// under hw/; whoever builds a cell knows only what is here.
namespace takt::device {

/// What is on the other end of a device's back end. Start-up, verdict and recording say it for every device.
enum class BackendMode : std::uint8_t {
  kSimulated,  ///< SIM: the device is simulated in this process, without a wire
  kEmulated,   ///< EMULATED: the driver of the real device, against an emulated controller
  kHardware    ///< HARDWARE: something moves
};
/// "SIM", "EMULATED", "HARDWARE".
[[nodiscard]] std::string_view name_of(BackendMode reality);

/// What a site says of one device that has a driver: read from a site file, or from ADDR of --backend. Each kind
/// derives what it needs.
struct DriverSettings {
  virtual ~DriverSettings() = default;
  std::string address;         ///< as given: "192.0.2.1:49938"; "virtual": an emulated controller in this process
  bool emulated_peer = false;  ///< the other end is known to be an emulator

  /// Driver and emulated controller share the process and its virtual time.
  [[nodiscard]] bool in_process() const { return address == "virtual"; }
  [[nodiscard]] BackendMode reality() const {
    return in_process() || emulated_peer ? BackendMode::kEmulated : BackendMode::kHardware;
  }
};

/// What a driver, or an emulator, is told of the arm that it is for.
struct DriverRequest {
  std::string device;  ///< its name in the cell
  std::shared_ptr<const ArmDescription> description;
  Nanoseconds core_period = kMillisecond;
  Nanoseconds padding = 0;  ///< added to the delay, to be as late as the slowest arm of a group (row T3)
  std::uint64_t seed = 0;   ///< of the faults of a virtual wire
  /// An I/O block of the cell whose terminals are those of the arm's controller; null: none is.
  std::shared_ptr<const IoDescription> terminals = nullptr;
};

class IoDriver;
struct IoTerminals;

/// The driver of a device: an I/O agent with its wire. It is there when it is made and looks for its device from then
/// on; samples come when the device is found. Its destructor ends the connection in order, without moving anything.
class DeviceDriver {
 public:
  virtual ~DeviceDriver() = default;
  /// Asks the device to accept commands again, after it stopped by itself: the explicit reset without which nothing
  /// begins anew (row S4). Any thread.
  virtual void reset() {}
  /// What changed since the last call, a line each: "state MON, quality 2", "lost 3 packets". Called now and then by a
  /// thread that is not the cycle. Realtime: setup.
  [[nodiscard]] virtual std::vector<std::string> news() { return {}; }
  /// What the driver refused about the device that answers, and what to change; empty: nothing. Thread: that of
  /// news(). Realtime: setup.
  [[nodiscard]] virtual std::string refusal() const { return {}; }
  /// All that its future depends on, for the digest; only of a driver in virtual time, else empty. Stays where it is.
  [[nodiscard]] virtual std::span<const std::byte> state() const { return {}; }
};

/// How the connection of a driver has been so far.
struct ConnectionCounts {
  InletCounts samples;
  std::uint64_t dry = 0;  ///< how often the set points ran out
  double drift = 0.0;     ///< core seconds per device second, less 1
};

/// The driver of an arm.
class ArmDriver : public ArmBackend, public DeviceDriver {
 public:
  /// The wrench that the arm itself estimates or measures, on its flange, as a sensor that is mounted there reads it;
  /// null: it has none. Lives as long as the driver.
  [[nodiscard]] virtual ForceTorqueBackend* force_torque() { return nullptr; }
  /// As of the newest sample. Cycle thread. Realtime: cyclic.
  [[nodiscard]] virtual ConnectionCounts connection() const = 0;
  /// When the newest packet of the device came, or would have come without jitter, on the machine's clock
  /// (Clock::Reading); null: its packets do not come at a pace of its own, or none come. Cycle thread. Realtime:
  /// cyclic.
  [[nodiscard]] virtual std::optional<Nanoseconds> packet_time() const { return std::nullopt; }
  /// The terminals of the controller, over the connection of the arm, if DriverRequest::terminals asked for them; null:
  /// it did not, or the controller has none. They live as long as the driver. @param machine  what is behind the
  /// terminals of an emulated controller in this process; else of no use. Realtime: setup.
  [[nodiscard]] virtual IoDriver* terminals(const IoTerminals& /*machine*/) { return nullptr; }
};

/// The driver of a gripper.
class GripperDriver : public GripperBackend, public DeviceDriver {
 public:
  /// Why the gripper is not ready, from GripperSample::fault; empty: it is, or the fault is not one of this driver.
  /// Any thread. Realtime: setup.
  [[nodiscard]] virtual std::string fault_text(std::uint32_t fault) const = 0;
};

/// The back ends of the terminals of an I/O block, by the names of its model (IoChannel::name).
struct IoTerminals {
  std::map<std::string, std::shared_ptr<SignalInputBackend<bool>>, std::less<>> digital_inputs;
  std::map<std::string, std::shared_ptr<SignalInputBackend<double>>, std::less<>> analog_inputs;
  std::map<std::string, std::shared_ptr<SignalOutputBackend<bool>>, std::less<>> digital_outputs;
  std::map<std::string, std::shared_ptr<SignalOutputBackend<double>>, std::less<>> analog_outputs;
};

/// The driver of an I/O block.
class IoDriver : public DeviceDriver {
 public:
  /// All terminals of the block's model; of use while the driver lives.
  [[nodiscard]] virtual const IoTerminals& terminals() const = 0;
  /// Its outputs accept values, its inputs have samples. Cycle thread. Realtime: cyclic.
  [[nodiscard]] virtual bool ready() const = 0;
  /// Why it is not ready; empty: it is. Cycle thread. Realtime: setup.
  [[nodiscard]] virtual std::string fault_text() const = 0;
};

/// The controller's side of a protocol, around a machine that accepts set points each cycle. One thread calls
/// advance().
class ControllerEmulator {
 public:
  virtual ~ControllerEmulator() = default;
  /// Once in each cycle of the machine, before it steps: reads it, answers what came over the wire, writes the set
  /// point, sends. `now` is the core's time of the emulating process, cycle times period.
  virtual void advance(Nanoseconds now) = 0;
  /// Tool and payload as they are entered at the controller. Realtime: setup.
  virtual void set_tool(const ToolSetting& /*tool*/) {}
  /// The brakes of the machine, for its power and for who resets it after it has stopped by itself: opened, it holds
  /// its joints where they are. Realtime: setup.
  virtual void set_brakes(std::function<void()> /*close*/, std::function<void()> /*open*/) {}
  /// What is behind its terminals, if DriverRequest::terminals asked for them. Realtime: setup.
  virtual void set_terminals(const IoTerminals& /*machine*/) {}
  /// As of DeviceDriver.
  [[nodiscard]] virtual std::vector<std::string> news() { return {}; }
};

/// A kind of back end that speaks a protocol: "fri", "wsg". It is an ArmDriverKind, GripperDriverKind or IoDriverKind.
/// One object serves all devices; it has no state. Realtime: setup.
class DriverKind {
 public:
  /// @param name  as "backend" in a site file and KIND of --backend @param doc  one line for people
  /// @param form  what a site file may say beside "backend" (docs/tables.md)
  DriverKind(std::string name, std::string doc, Form form)
      : name_(std::move(name)), doc_(std::move(doc)), form_(std::move(form)) {}
  virtual ~DriverKind() = default;
  DriverKind(const DriverKind&) = delete;
  DriverKind& operator=(const DriverKind&) = delete;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& doc() const { return doc_; }
  [[nodiscard]] const Form& form() const { return form_; }

  /// Reads the settings; asks for all keys of the form. ADDR of --backend is "ADDRESS,key=value,...": the first part
  /// without '=' is "address"; numbers and true/false keep their types. Errors go to the reader. @return never null
  [[nodiscard]] virtual std::shared_ptr<const DriverSettings> read(FormReader& from) const = 0;

 private:
  std::string name_, doc_;
  Form form_;
};

/// A kind that drives arms.
class ArmDriverKind : public DriverKind {
 public:
  using DriverKind::DriverKind;
  /// What keeps this driver from this arm, beyond its settings: another number of joints, another cycle. Empty:
  /// nothing.
  [[nodiscard]] virtual std::string refuse(const DriverSettings& settings, const ArmDescription& arm) const = 0;
  /// What keeps the terminals of the arm's controller from being those of a block. Empty: nothing.
  [[nodiscard]] virtual std::string refuse_terminals(const IoDescription& /*io*/) const {
    return "the arm's controller offers no terminals";
  }
  /// The device has a clock of its own, at whose pace its packets come; false: it follows this side's.
  [[nodiscard]] virtual bool paces() const { return true; }
  /// The cycle in which the device takes set points, ns.
  [[nodiscard]] virtual Nanoseconds cycle(const DriverSettings& settings, const ArmDescription& arm) const = 0;
  /// Declared delay of its set points without padding, ns.
  [[nodiscard]] virtual Nanoseconds delay(const DriverSettings& settings, const ArmDescription& arm,
                                          Nanoseconds core_period) const = 0;

  /// Opens the wire. @param clock  the core's time, on the machine's; outlives the driver
  [[nodiscard]] virtual Result<std::shared_ptr<ArmDriver>> connect(const DriverSettings& settings,
                                                                   const DriverRequest& request,
                                                                   const Clock& clock) const = 0;
  /// Driver and emulated controller on a virtual wire, in lock-step: read() makes time go on by one core cycle.
  /// @param machine  the arm behind the controller, which lives in the core's cycle
  [[nodiscard]] virtual Result<std::shared_ptr<ArmDriver>> connect_in_process(
      const DriverSettings& settings, const DriverRequest& request, std::shared_ptr<ArmBackend> machine) const = 0;
  /// The controller's side alone, on the machine's sockets, for `takt emulate`.
  [[nodiscard]] virtual Result<std::unique_ptr<ControllerEmulator>> emulate(
      const DriverSettings& settings, const DriverRequest& request, std::shared_ptr<ArmBackend> machine) const = 0;
};

/// What a driver, or an emulator, of a device that is no arm is told of it.
template <class Description>
struct DeviceRequest {
  std::string device;  ///< its name in the cell
  std::shared_ptr<const Description> description;
  Nanoseconds core_period = kMillisecond;
  std::uint64_t seed = 0;  ///< of the faults of a virtual wire
};
using GripperRequest = DeviceRequest<GripperDescription>;
using IoRequest = DeviceRequest<IoDescription>;

/// A kind that drives grippers. Functions as of ArmDriverKind.
class GripperDriverKind : public DriverKind {
 public:
  using DriverKind::DriverKind;
  [[nodiscard]] virtual std::string refuse(const DriverSettings& settings, const GripperDescription& gripper) const = 0;
  /// From one sample to the next, ns.
  [[nodiscard]] virtual Nanoseconds cycle(const DriverSettings& settings, const GripperDescription& gripper) const = 0;
  [[nodiscard]] virtual Result<std::shared_ptr<GripperDriver>> connect(const DriverSettings& settings,
                                                                       const GripperRequest& request,
                                                                       const Clock& clock) const = 0;
  [[nodiscard]] virtual Result<std::shared_ptr<GripperDriver>> connect_in_process(
      const DriverSettings& settings, const GripperRequest& request, std::shared_ptr<GripperBackend> machine) const = 0;
  [[nodiscard]] virtual Result<std::unique_ptr<ControllerEmulator>> emulate(
      const DriverSettings& settings, const GripperRequest& request, std::shared_ptr<GripperBackend> machine) const = 0;
};

/// A kind that drives I/O blocks. Functions as of ArmDriverKind; time goes on by one core cycle when a terminal is
/// looked at for the second time.
class IoDriverKind : public DriverKind {
 public:
  using DriverKind::DriverKind;
  [[nodiscard]] virtual std::string refuse(const DriverSettings& settings, const IoDescription& io) const = 0;
  [[nodiscard]] virtual Nanoseconds cycle(const DriverSettings& settings, const IoDescription& io) const = 0;
  [[nodiscard]] virtual Result<std::shared_ptr<IoDriver>> connect(const DriverSettings& settings,
                                                                  const IoRequest& request,
                                                                  const Clock& clock) const = 0;
  [[nodiscard]] virtual Result<std::shared_ptr<IoDriver>> connect_in_process(const DriverSettings& settings,
                                                                             const IoRequest& request,
                                                                             const IoTerminals& machine) const = 0;
  [[nodiscard]] virtual Result<std::unique_ptr<ControllerEmulator>> emulate(const DriverSettings& settings,
                                                                            const IoRequest& request,
                                                                            const IoTerminals& machine) const = 0;
};

/// All kinds of the process. A program adds those that it is linked with before it reads a site
/// (hw/drivers.h: hw::add_own_drivers()). Realtime: setup.
class DriverKinds {
 public:
  static DriverKinds& global();
  /// A name that is taken already is ignored.
  void add(std::unique_ptr<DriverKind> kind);
  /// @return null: there is none
  [[nodiscard]] const DriverKind* find(std::string_view name) const;
  [[nodiscard]] const std::vector<std::unique_ptr<DriverKind>>& list() const { return kinds_; }

 private:
  std::vector<std::unique_ptr<DriverKind>> kinds_;
};

}  // namespace takt::device
