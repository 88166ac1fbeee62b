#pragma once

#include <algorithm>

#include "core/base/clock.h"
#include "core/base/newest_slot.h"
#include "core/device/backend.h"
#include "core/device/clock_estimator.h"
#include "core/device/sample_inlet.h"

namespace takt::device {

/// The I/O agent of a force/torque sensor that has a clock of its own (row T2): the incoming half of ArmAgent.
class ForceTorqueAgent {
 public:
  struct Report {
    InletCounts samples;
    double drift = 0.0;
    Nanoseconds offset = 0, jitter = 0;
  };

  /// @param clock  the core's time; must outlive the agent. Realtime: setup.
  explicit ForceTorqueAgent(const Clock& clock) : clock_(clock) {}

  /// The core's side: the newest sample, as ForceTorqueBackend::read(). Realtime: cyclic, wait-free.
  bool read(WrenchSample& sample) {
    inbound_.take();
    sample = inbound_.value().sample;
    return sample.sequence > 0;
  }
  [[nodiscard]] const Report& report() const { return inbound_.value().report; }

  /// The device's side: a sample has arrived now; `sequence` and `stamp` as the device gives them. Realtime: cyclic.
  /// @param instant  of the device's cycle, on its clock
  void take(const WrenchSample& sample, Nanoseconds instant) {
    if (!inlet_.accept(sample.sequence)) return;
    const Nanoseconds now = clock_.now();
    estimator_.add(instant, now);
    Inbound inbound{sample, {inlet_.counts(), estimator_.drift(), estimator_.offset(), estimator_.jitter()}};
    inbound.sample.stamp = std::min(estimator_.to_core(sample.stamp), now);
    inbound_.publish(inbound);
  }

 private:
  struct Inbound {
    WrenchSample sample;
    Report report;
  };

  const Clock& clock_;
  NewestSlot<Inbound> inbound_;
  SampleInlet inlet_;
  ClockEstimator estimator_;
};

}  // namespace takt::device
