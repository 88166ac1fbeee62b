#pragma once

#include <cstdint>

#include "core/base/time.h"
#include "core/device/clock_estimator.h"
#include "core/device/sample_inlet.h"

namespace takt::device {

/// What a device says of one of its cycles: the number that it counts them by, and what its clock shows.
struct DeviceCycle {
  std::uint64_t sequence = 0;  ///< wraps after `sequence_bits`
  Nanoseconds stamp = 0;
};

/// The packets of a device from when it begins to count until it falls silent or begins anew (row T2). The instant of a
/// packet follows from its number: so many cycles after the first one of the session, whatever the device's clock shows
/// later. The clock is only a plausibility check: one that is set changes nothing but a count; one that disagrees with
/// the counter packet after packet ends the session, because then the length of a cycle is unknown.
///
/// Only numbers that can be are accepted: newer than all before, and not earlier than the device can have come to them.
/// The session ends when the device was silent for more cycles than a device bridges, or when kRun packets in a row,
/// each a little newer than the one before, do not belong to it: the other end began to count anew. The next session
/// opens only when its owner allows it, after kRun packets in a row that belong together.
/// One thread. Realtime: cyclic, O(1).
class DeviceSession {
 public:
  /// Packets in a row that must agree before a device that counts otherwise is believed.
  static constexpr int kRun = 8;
  /// Cycles without a packet after which any device has stopped by itself (docs/devices.md, "What a back end owes").
  static constexpr int kBridged = 20;

  struct Options {
    Nanoseconds cycle = kMillisecond;  ///< of the device, > 0
    int sequence_bits = 64;            ///< of its counter, 8 to 64; it wraps
    Nanoseconds jitter = 0;            ///< of the wire, as far as it is known
    bool ends_when_silent = true;      ///< false for a sensor, which moves nothing
  };
  enum class Verdict : std::uint8_t {
    kDropped,   ///< old, repeated, implausible, or there is no session
    kAccepted,  ///< the newest of the session
    kOpened,    ///< the first of a session
    kEnded      ///< dropped, and it ended the session: end() says why
  };
  enum class End : std::uint8_t {
    kNone,
    kSilent,     ///< no packet for kBridged cycles
    kRestarted,  ///< the device counts anew
    kDisagrees,  ///< its clock and its counter do
    kFailed      ///< close(): whoever answers the device could not
  };

  explicit DeviceSession(const Options& options) : options_(options) {}

  /// A packet has come. @param received  on the machine's clock. @param may_open  a session after the first may begin
  Verdict take(const DeviceCycle& packet, Nanoseconds received, bool may_open);
  /// Ends the session, if there is one, for a reason of its owner's: kFailed. What came before counts for nothing.
  void close();
  /// A packet was dropped before it came here.
  void count_implausible() { ++inlet_.counts().implausible; }

  [[nodiscard]] bool open() const { return open_; }
  [[nodiscard]] End end() const { return end_; }
  /// Of the newest packet, by its number: on the clock that the device showed when the session began.
  [[nodiscard]] Nanoseconds instant() const { return instant_; }
  /// Of the newest packet: grows over all sessions and wraps of the device's counter; 0 before the first.
  [[nodiscard]] std::uint64_t number() const { return inlet_.newest(); }
  /// When something was measured that the newest packet says was at `stamp`, on the machine's clock and not in the
  /// future. A stamp that cannot be gets the age of the one before.
  [[nodiscard]] Nanoseconds measured_at(Nanoseconds stamp, Nanoseconds received);

  [[nodiscard]] const ClockEstimator& estimator() const { return estimator_; }
  [[nodiscard]] const InletCounts& counts() const { return inlet_.counts(); }
  /// How often the device's clock was set, as far as it shows between two packets.
  [[nodiscard]] std::uint64_t clock_steps() const { return clock_steps_; }

 private:
  [[nodiscard]] std::int64_t ahead_of(std::uint64_t sequence, std::uint64_t other) const;
  [[nodiscard]] bool clock_agrees(const DeviceCycle& packet, const DeviceCycle& before, std::int64_t cycles) const;
  [[nodiscard]] bool too_early(std::int64_t cycles, Nanoseconds received) const;
  Verdict take_old(const DeviceCycle& packet, std::int64_t ahead);
  Verdict take_new(const DeviceCycle& packet, std::int64_t ahead, Nanoseconds received);
  Verdict begin(const DeviceCycle& packet, Nanoseconds received);
  Verdict finish(End why, const DeviceCycle& packet);
  Verdict refuse(const DeviceCycle& packet);
  void extend_run(const DeviceCycle& packet);

  Options options_;
  SampleInlet inlet_;
  ClockEstimator estimator_;
  bool open_ = false;
  End end_ = End::kNone;
  DeviceCycle newest_;
  Nanoseconds instant_ = 0, received_ = 0;
  int disagreeing_ = 0;  // packets in a row whose clock disagrees with their number
  std::uint64_t clock_steps_ = 0;
  Nanoseconds age_ = 0;  // of the last plausible measurement, at the instant of its packet
  DeviceCycle refused_;  // the last one
  int run_ = 0;          // refused packets in a row that belong together
};

}  // namespace takt::device
