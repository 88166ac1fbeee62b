#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/device/arm_agent.h"
#include "core/device/brake_ramp.h"
#include "core/device/driver.h"
#include "core/emulation/state_hash.h"
#include "hw/cia402/field_bus.h"
#include "hw/cia402/protocol/drive_state.h"

namespace takt::hw::cia402 {

/// Cycles of the bus from what the drives report to the set point that answers it: it is taken at the next SYNC, and
/// the drives are there one cycle later.
inline constexpr int kLeadCycles = 2;

struct ClientOptions {
  Nanoseconds cycle = 4 * kMillisecond;  ///< of the bus
  Nanoseconds margin = 0;                ///< for what the jitter of core and bus can take away

  [[nodiscard]] device::AgentTiming timing(Nanoseconds core_period, Nanoseconds padding) const {
    return {.core_period = core_period,
            .device_cycle = cycle,
            .lead_cycles = kLeadCycles,
            .margin = margin,
            .padding = padding};
  }
};

/// Causes of an arm that is not ready (ArmSample::fault), beside those of a drive.
enum class ClientFault : std::uint32_t {
  kNone = 0,
  kNotEnabled = 0x4020'0001,  ///< on the way to "operation enabled"
  kStopped,                   ///< a drive left "operation enabled" without an error: somebody else's doing
  kSwitchedOff,               ///< brakes were asked for, or the program ends
  kOtherMode,                 ///< a drive is not in mode CSP
};
/// A fault that stands for the error code of the drive of a joint.
[[nodiscard]] constexpr std::uint32_t drive_fault(std::size_t joint, std::uint16_t code) {
  return 0x4100'0000u | static_cast<std::uint32_t>(joint) << 16 | code;
}

/// An arm of drives on a field bus: leads all of them together through the states of CiA 402, and gives them the
/// core's set points. When one of them leaves "operation enabled", all stop, and stay so until reset(). This side is
/// the clock: whoever owns it calls begin_cycle() in each cycle of the bus, and poll(). The core's side is used by the
/// cycle thread, the device's by one other (or the same).
class Client {
 public:
  /// @param clock  the core's time; outlives the client. Realtime: setup
  Client(const device::DriverRequest& request, const ClientOptions& options, std::unique_ptr<FieldBus> bus,
         const Clock& clock);

  // -- The core's side. Realtime: cyclic, wait-free.
  bool read(device::ArmSample& sample);
  void write(const device::ArmSetPoint& set_point) { agent_.write(set_point); }
  void set_held(bool held) { agent_.set_held(held); }
  void brake() { agent_.brake(); }
  /// The drives on again, errors taken back. Any thread.
  void reset() { resets_.fetch_add(1, std::memory_order_release); }
  [[nodiscard]] const device::AgentTiming& timing() const { return agent_.timing(); }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const;

  // -- The device's side: one thread. Realtime: cyclic once the drives run.
  void begin_cycle();
  /// Takes what has come, and answers it.
  void poll();
  void wait(Nanoseconds timeout) { bus_->wait(timeout); }
  /// From now on the drives are switched off; true once they are, or cannot be reached.
  bool leave();
  [[nodiscard]] std::int64_t cycle() const { return cycle_; }
  [[nodiscard]] const device::ArmAgent& agent() const { return agent_; }
  [[nodiscard]] FieldBus& bus() { return *bus_; }
  void add_state(emulation::StateHash& hash) const;

  // -- Any one thread.
  [[nodiscard]] std::vector<std::string> news();
  /// As of DeviceDriver.
  [[nodiscard]] std::string refusal() const;

 private:
  /// What the master knows of one drive.
  struct Axis {
    DriveState state = DriveState::kNotReadyToSwitchOn;
    DriveOutputs outputs;  // sent last
    double held = 0.0;     // rad: where it is told to be while nothing moves
  };
  /// Where the drives are told to be at an instant.
  struct ReportedState {
    std::int64_t cycle = -1;
    device::JointVector q;
  };

  void take_requests();
  void answer();
  void take_states();
  void stop(std::uint32_t fault);
  [[nodiscard]] bool all_enabled() const;
  [[nodiscard]] std::uint32_t cause() const;
  [[nodiscard]] Wanted wanted() const;
  [[nodiscard]] device::ArmPacket packet() const;
  [[nodiscard]] device::JointVector told_now() const;
  [[nodiscard]] motion::JointSample next_set_point(const std::optional<device::ArmAnswer>& answer);
  void send(const motion::JointSample& set_point);
  [[nodiscard]] std::uint16_t control(const Axis& axis) const;
  void collect_lines();

  std::shared_ptr<const device::ArmDescription> arm_;
  ClientOptions options_;
  std::unique_ptr<FieldBus> bus_;
  const Clock& clock_;
  device::ArmAgent agent_;

  std::atomic<int> resets_ = 0;

  // The device's side.
  std::vector<Axis> axes_;
  std::vector<DriveOutputs> outputs_;
  std::array<ReportedState, 4> told_;
  std::int64_t cycle_ = -1;
  int resets_seen_ = 0;
  bool enabled_ = false;   // all drives, in the cycle before
  bool stopped_ = false;   // until reset()
  bool off_ = false;       // at once, not by a ramp
  bool may_reset_ = true;  // errors are taken back: a start is a reset
  bool leaving_ = false;
  std::uint32_t fault_ = 0;   // why it is stopped
  motion::JointSample last_;  // set point sent last
  bool following_ = false;    // it was the agent's
  std::optional<device::BrakeRamp> ramp_;
  std::int64_t ramp_begin_ = 0;

  mutable std::mutex lines_mutex_;
  std::string refusal_;  // guarded by lines_mutex_, as lines_
  std::vector<std::string> lines_;
};

}  // namespace takt::hw::cia402
