#pragma once

#include <algorithm>

#include "core/base/clock.h"
#include "core/base/newest_slot.h"
#include "core/device/backend.h"
#include "core/device/device_session.h"

namespace takt::device {

/// The I/O agent of a force/torque sensor that has a clock of its own (row T2): the incoming half of ArmAgent. Nothing
/// moves by it, so silence ends no session and a sensor that counts anew is believed after DeviceSession::kRun samples.
class ForceTorqueAgent {
 public:
  struct Report {
    InletCounts samples;
    double drift = 0.0;
    Nanoseconds offset = 0, jitter = 0;
  };

  /// @param clock  the core's time; must outlive the agent @param cycle  of the sensor @param jitter  of the wire, as
  /// far as it is known @param sequence_bits  after so many its counter wraps. Realtime: setup.
  ForceTorqueAgent(const Clock& clock, Nanoseconds cycle, Nanoseconds jitter, int sequence_bits = 64)
      : clock_(clock),
        session_({.cycle = cycle, .sequence_bits = sequence_bits, .jitter = jitter, .ends_when_silent = false}) {}

  /// The core's side: the newest sample, as ForceTorqueBackend::read(). Realtime: cyclic, wait-free.
  bool read(WrenchSample& sample) {
    inbound_.take();
    sample = inbound_.value().sample;
    sample.stamp -= clock_.read().skipped;
    return sample.sequence > 0;
  }
  [[nodiscard]] const Report& report() const { return inbound_.value().report; }

  /// The device's side: a sample has arrived now; `sequence` and `stamp` as the device gives them. Realtime: cyclic.
  /// @param instant  of the device's cycle, as its clock shows it now
  void take(const WrenchSample& sample, Nanoseconds instant) {
    const Nanoseconds now = clock_.read().machine;
    const auto verdict = session_.take({sample.sequence, instant}, now, /*may_open=*/true);
    if (verdict != DeviceSession::Verdict::kAccepted && verdict != DeviceSession::Verdict::kOpened) return;
    const ClockEstimator& estimator = session_.estimator();
    Inbound inbound{sample, {session_.counts(), estimator.drift(), estimator.offset(), estimator.jitter()}};
    inbound.sample.sequence = session_.number();
    inbound.sample.stamp = session_.measured_at(sample.stamp, now);
    inbound_.publish(inbound);
  }

 private:
  struct Inbound {
    WrenchSample sample;  // stamped on the machine's clock: what the core leaves out by then is taken off when it reads
    Report report;
  };

  const Clock& clock_;
  NewestSlot<Inbound> inbound_;
  DeviceSession session_;
};

}  // namespace takt::device
