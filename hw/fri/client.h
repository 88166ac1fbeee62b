#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "core/base/newest_slot.h"
#include "core/device/arm_agent.h"
#include "core/device/driver.h"
#include "core/device/force_torque_agent.h"
#include "hw/fri/supervisor.h"
#include "hw/wire/datagram_link.h"

namespace takt::hw::fri {

/// How the remote side of the interface is set up.
struct ClientOptions {
  Nanoseconds cycle = kMillisecond;  ///< of the interface: friOpen()
  std::string krl = "takt";          ///< convention of the KRL program
  bool task_frame_is_tool = false;   ///< $STIFFNESS.TASKFRAME
  std::uint32_t controller = 0;      ///< its address; 0: whoever sends first
  Nanoseconds margin = 0;            ///< for what the jitter of wire and core can take away

  [[nodiscard]] device::AgentTiming timing(Nanoseconds core_period, Nanoseconds padding) const {
    return {.core_period = core_period,
            .device_cycle = cycle,
            .lead_cycles = 2,
            .margin = margin,
            .padding = padding,
            .sequence_bits = 16};
  }
};

/// What the wire brought, and how the controller is.
struct ClientReport {
  State state = State::kOff;
  Quality quality = Quality::kUnacceptable;
  Statistics statistics;
  Fault fault = Fault::kMonitor;
  std::uint16_t power = 0, error = 0, warning = 0;
  double hottest = 0.0;            ///< of the drives, deg C
  std::uint64_t measurements = 0;  ///< datagrams that counted
  std::uint64_t answers = 0;
  std::uint64_t strangers = 0;  ///< from another host, or another port than the session's
  std::uint64_t misread = 0;    ///< of another length, version or direction
  std::uint64_t old = 0;        ///< repeated, overtaken, or of no session
  std::uint64_t unsent = 0;
  device::AgentReport agent;
};

/// The remote side of FRI: answers each datagram of the controller at once, mirrors where the arm is told to be until
/// it may be moved, asks KRL for command state and control mode, and otherwise says what the I/O agent says. The core's
/// side is used by the cycle thread, the device's by one other (or the same). Who owns it makes it go (Driver, Twin).
class Client {
 public:
  /// @param clock  the core's time; outlives the client. Realtime: setup
  Client(const device::DriverRequest& request, const ClientOptions& options, std::unique_ptr<DatagramLink> link,
         const Clock& clock);

  // -- The core's side. Realtime: cyclic, wait-free.
  bool read(device::ArmSample& sample);
  /// What the surroundings exert on the tool by the controller's own estimate, as ForceTorqueBackend::read(): at the
  /// origin of the flange and in its axes, N and Nm.
  bool read_wrench(device::WrenchSample& sample) { return force_agent_.read(sample); }
  void write(const device::ArmSetPoint& set_point) { agent_.write(set_point); }
  void write_compliance(const device::Compliance& compliance);
  void change_mode(device::ControlMode mode);
  void set_tool(const device::ToolSetting& tool);
  void set_held(bool held) { agent_.set_held(held); }
  void brake() { agent_.brake(); }
  /// Command state again, after it was lost. Any thread.
  void reset() { resets_.fetch_add(1, std::memory_order_release); }
  [[nodiscard]] const device::AgentTiming& timing() const { return agent_.timing(); }
  [[nodiscard]] static std::string fault_text(std::uint32_t fault);

  // -- The device's side: one thread. Realtime: cyclic.
  /// Waits for a datagram, at most `timeout`. @return false: none came
  bool wait(Nanoseconds timeout) { return link_->wait(timeout); }
  /// Answers all datagrams that are there.
  void serve();
  /// Drops all datagrams that are there, as if nobody had been here.
  void discard();
  /// From now on monitor state is asked for; true once the controller is in it, or has been silent for a while.
  bool leave();
  /// Takes a datagram as if the controller had sent it.
  void take(std::span<const std::byte> datagram) { take(datagram, controller_); }
  /// For the digest and for tests: as of the last datagram.
  [[nodiscard]] const ClientReport& report() const { return report_; }
  [[nodiscard]] const device::ArmAgent& agent() const { return agent_; }
  /// Position commanded last, rad.
  [[nodiscard]] const Joints& commanded() const { return answered_; }

  // -- Any one thread.
  [[nodiscard]] std::vector<std::string> news();
  /// As of DeviceDriver; thread of news().
  [[nodiscard]] std::string refusal();

 private:
  /// What the core says beside set points.
  struct Settings {
    device::Compliance compliance;
    Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
  };
  struct ObservedState {
    std::uint16_t sequence = 0;
    std::int64_t cycle = 0;  // counted on over wraps
    Joints q = Joints::Zero(), dq = Joints::Zero();
    bool any = false;
  };

  void take(std::span<const std::byte> datagram, const Endpoint& from);
  [[nodiscard]] bool is_stranger(const Endpoint& from);
  void answer(const Measurement& m);
  void take_requests();
  [[nodiscard]] std::int64_t ahead(const Measurement& m) const;
  [[nodiscard]] Joints velocity(const Measurement& m, std::int64_t ahead) const;
  [[nodiscard]] device::ArmPacket packet(const Measurement& m, std::int64_t ahead) const;
  void take_wrench(const Measurement& m, Nanoseconds instant);
  [[nodiscard]] Joints held(const Measurement& m) const;
  [[nodiscard]] Joints next_position(const Measurement& m, const std::optional<device::ArmAnswer>& answer);
  void brake_by_ramp();
  void fill_command(const Measurement& m, const Joints& q);
  void fill_compliance();
  [[nodiscard]] bool fits_task_frame(const device::Compliance& compliance) const;
  void send();
  void publish(const Measurement& m);

  std::shared_ptr<const device::ArmDescription> arm_;
  ClientOptions options_;
  std::unique_ptr<DatagramLink> link_;
  const Clock& clock_;
  device::ArmAgent agent_;
  device::ForceTorqueAgent force_agent_;
  std::unique_ptr<KrlHandshake> handshake_;

  // Between the two sides.
  NewestSlot<Settings> settings_;
  NewestSlot<ClientReport> published_;
  std::atomic<int> resets_ = 0;
  std::atomic<std::uint32_t> wanted_mode_ = 0;  // number of the request << 8 | mode

  // The core's side.
  Settings core_settings_;
  std::uint32_t mode_requests_ = 0;

  // The device's side.
  Supervisor supervisor_;
  ObservedState seen_;
  Endpoint controller_;
  Nanoseconds heard_ = 0;  // machine time
  int resets_seen_ = 0;
  std::uint32_t mode_seen_ = 0;
  bool leaving_ = false;
  Command command_;
  Joints answered_ = Joints::Zero();  // position commanded last, in full precision
  motion::JointSample last_state_;    // of the agent, answered last
  device::BrakeRamp ramp_;
  std::int64_t ramp_begin_ = -1;  // cycle; -1: there is none
  ClientReport report_;
  std::array<std::byte, DatagramLink::kLargest> buffer_{};

  // Whoever asks for news.
  ClientReport told_;
};

}  // namespace takt::hw::fri
