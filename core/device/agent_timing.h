#pragma once

#include "core/base/time.h"

namespace takt::device {

/// Declared times of an arm that has a clock of its own. The set point of time t is what the arm is told for
/// t + delay().
struct AgentTiming {
  Nanoseconds core_period = kMillisecond;
  Nanoseconds device_cycle = kMillisecond;
  /// A packet of device cycle n is answered with a set point for cycle n + lead_cycles: one cycle for the answer to
  /// travel, one that the device takes to go there.
  int lead_cycles = 2;
  Nanoseconds margin = 0;   ///< for what the wire's and the core's jitter can take away
  Nanoseconds padding = 0;  ///< to be as late as the slowest arm of a group (row T3)
  int sequence_bits = 64;   ///< of the counter of the device's cycles, 8 to 64: it wraps

  [[nodiscard]] Nanoseconds dead_time() const { return lead_cycles * device_cycle; }
  [[nodiscard]] Nanoseconds driver_delay() const { return core_period + margin + padding; }
  [[nodiscard]] Nanoseconds delay() const { return driver_delay() + dead_time(); }
};

}  // namespace takt::device
