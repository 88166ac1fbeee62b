#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include <boost/lockfree/spsc_queue.hpp>

#include "core/base/clock.h"
#include "core/base/newest_slot.h"
#include "core/device/agent_timing.h"
#include "core/device/answer_guard.h"
#include "core/device/backend.h"
#include "core/device/brake_ramp.h"
#include "core/device/device_session.h"
#include "core/device/set_point_series.h"
#include "core/motion/limits.h"

namespace takt::device {

/// What an arm says in one cycle of its own: its sample and the instant of the cycle, both on its own clock.
struct ArmPacket {
  /// `sequence` and `stamp` as the device gives them: `sequence` counts the device's cycles and wraps after
  /// AgentTiming::sequence_bits. `commanded` must be given, one finite entry per joint.
  ArmSample sample;
  Nanoseconds instant = 0;  ///< begin of the device's cycle, as its clock shows it now
};

/// What the agent answers: where the arm is to be at a later instant of its own.
struct ArmAnswer {
  std::uint64_t sequence = 0;  ///< of the packet that is answered
  std::uint64_t session = 0;   ///< counts up; instants of two sessions do not compare
  /// The packet's, `lead_cycles` later: by the number of cycles since the session began, on the clock that the device
  /// showed then.
  Nanoseconds instant = 0;
  motion::JointSample state;
  bool brake = false;  ///< category 0: close the brakes
};

/// What an agent tells of itself.
struct AgentReport {
  enum class Phase : std::uint8_t {
    kWaiting,    ///< no session with the device: nothing came yet, or it was silent, or it began anew
    kHolding,    ///< the arm stands where it was told last; no set points of the core yet
    kFollowing,  ///< the core's set points, resampled
    kBraking     ///< the agent's own ramp: the set points ran out
  };
  Phase phase = Phase::kWaiting;
  InletCounts samples;
  std::uint64_t stops = 0;             ///< how often readiness ended: by the agent or by the device
  std::uint64_t dry = 0;               ///< of these: the set points ran out
  std::uint64_t trips = 0;             ///< of these: the guard refused an answer
  std::uint64_t lost_sessions = 0;     ///< of these: the device fell silent or began anew
  std::optional<Violation> last_trip;  ///< what the guard refused last
  std::uint64_t clock_steps = 0;       ///< how often somebody set the device's clock
  std::uint64_t dropped = 0;           ///< set points that found the ring full
  double drift = 0.0;                  ///< core seconds per device second, less 1
  Nanoseconds offset = 0;              ///< core time less device time
  /// When the newest packet came, but for jitter, on the machine's clock. Null: there is no session.
  std::optional<Nanoseconds> packet_time;
  Nanoseconds jitter = 0;                 ///< of the wire, seen lately
  Nanoseconds reserve_least = INT64_MAX;  ///< how close the set points ever were to running out
};

/// The I/O agent of an arm (rows T2, T3): stands between the core's cycle and a device that has a clock of its own and
/// answers that device on its clock. It knows no wire: whoever receives a packet calls answer() with it and sends what
/// comes back, a thread on hardware (AgentThread), the simulation in lock-step. Back ends own one and pass read() and
/// write() on (docs/time.md).
///
/// In: samples sorted by number, stamped on the core's clock, the newest in a slot. Out: set points through a ring,
/// resampled to the device's instants with the fixed delay that is declared. The instants come from the device's
/// numbers (DeviceSession); its clock may be set at any time. Each answer is held to the one before by AnswerGuard.
/// When the set points run out, begin elsewhere than where the arm was told to be, or would make it step, the agent
/// stops the arm itself, within `limits`, and reports it as not ready until the core has seen that; only set points
/// that the core made after that move the arm again (row S4). A device that fell silent or counts anew is not answered
/// until no net holds the arm; then it is taken up where it says that it holds its joints.
class ArmAgent {
 public:
  /// Causes of the agent in ArmSample::fault, apart from those of devices.
  static constexpr std::uint32_t kDry = 0x8000'0001, kElsewhere = 0x8000'0002, kStep = 0x8000'0003,
                                 kSilent = 0x8000'0004, kRestarted = 0x8000'0005, kDisagrees = 0x8000'0006,
                                 kFailed = 0x8000'0007;
  /// Words for them; empty for a cause of the device. Realtime: setup.
  [[nodiscard]] static std::string fault_text(std::uint32_t fault);
  /// How fast the resampled time may run against the device's to make up for a better estimate of its clock: bounds
  /// what a correction adds to velocities.
  static constexpr double kSlew = 200e-6;

  /// @param clock  the core's time; must outlive the agent. Realtime: setup.
  ArmAgent(const motion::JointLimits& limits, const AgentTiming& timing, const Clock& clock);

  [[nodiscard]] const AgentTiming& timing() const { return timing_; }

  // -- The core's side: cycle thread. Realtime: cyclic, wait-free.
  // -----------------------------------------------------
  /// The newest sample, as ArmBackend::read().
  bool read(ArmSample& sample);
  /// As ArmBackend::write().
  void write(const ArmSetPoint& set_point);
  /// Category 0 at the next answers, until the device is seen not ready.
  void brake() { brake_requested_.store(true, std::memory_order_release); }
  /// As ArmBackend::set_held(): while a net holds the arm, no new session begins.
  void set_held(bool held) { held_.store(held, std::memory_order_release); }
  /// As of the newest sample.
  [[nodiscard]] const AgentReport& report() const { return inbound_.value().report; }

  // -- The device's side: one thread. Realtime: cyclic. ---------------------------------------------------------------
  /// A packet has arrived now.
  /// @return the answer, or nothing for a packet that is repeated, older than one that came before, or implausible, and
  /// while there is no session.
  std::optional<ArmAnswer> answer(const ArmPacket& packet);
  /// What answers the device has failed in the middle of it: the session ends (kFailed), the arm is not ready, and the
  /// next session begins as after a silence.
  void fail();
  /// The core's time that the last answer was resampled at: the answer is the core's motion of that time.
  [[nodiscard]] Nanoseconds resampled_time() const { return target_; }
  [[nodiscard]] AgentReport::Phase phase() const { return phase_; }

 private:
  using Phase = AgentReport::Phase;
  struct Tagged {
    ArmSetPoint set_point;
    std::uint64_t stops = 0;  // that the core had seen when it made the set point
  };
  struct Inbound {
    ArmSample sample;  // stamped on the machine's clock: what the core leaves out by then is taken off when it reads
    bool willing = false;
    AgentReport report;
  };

  [[nodiscard]] bool usable(const ArmSample& sample) const;
  [[nodiscard]] bool may_open() const;
  void begin_session();
  void lose_session();
  void take_state(const ArmSample& sample);
  void take_set_points();
  void advance_target(Nanoseconds instant, Nanoseconds skipped);
  motion::JointSample next_state(Nanoseconds instant);
  motion::JointSample follow(Nanoseconds instant);
  motion::JointSample start_braking(Nanoseconds instant);
  motion::JointSample continue_braking(Nanoseconds instant);
  void end_readiness(std::uint32_t fault);
  void take_sample(const ArmSample& sample, Nanoseconds received);
  void publish();

  const motion::JointLimits limits_;
  const AgentTiming timing_;
  const Clock& clock_;

  // Between the two sides.
  NewestSlot<Inbound> inbound_;
  boost::lockfree::spsc_queue<Tagged, boost::lockfree::capacity<256>> ring_;
  std::atomic<bool> brake_requested_ = false;
  std::atomic<std::uint64_t> dropped_ = 0;
  std::atomic<std::uint64_t> stops_shown_ = 0;  // of the report that the core has read
  std::atomic<bool> held_ = false;              // by a net, in the cycle that reads

  // The core's side.
  std::uint64_t stops_seen_ = 0;

  // The device's side.
  DeviceSession session_;
  AnswerGuard guard_;  // knows what was answered last
  SetPointSeries series_;
  AgentReport report_;
  Inbound newest_;  // what was published last
  Phase phase_ = Phase::kWaiting;
  bool device_ready_ = false;
  std::uint32_t fault_ = 0;
  Nanoseconds target_ = 0;      // on the core's clock: what the last answer is resampled at
  Nanoseconds target_for_ = 0;  // the instant that target_ belongs to
  BrakeRamp ramp_;
  Nanoseconds ramp_begin_ = 0;
};

}  // namespace takt::device
