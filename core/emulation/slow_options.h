#pragma once

#include <algorithm>

#include "core/base/time.h"
#include "core/device/agent_timing.h"
#include "core/emulation/device_clock.h"
#include "core/emulation/wire.h"

namespace takt::emulation {

/// How a slow device differs from one that lives in the core's cycle.
struct SlowOptions {
  Nanoseconds cycle = 8 * kMillisecond;  ///< of the device, on its own clock
  Nanoseconds clock_offset = 0;          ///< its clock shows this when the core's shows 0
  double drift = 0.0;                    ///< s its clock gains per second
  WireFaults wire = {};                  ///< both ways, drawn apart
  /// Cycles without an answer that the arm bridges; with more it stops by itself and is not ready.
  int answer_timeout_cycles = 3;
  Nanoseconds padding = 0;  ///< added to the set points' delay, to be as late as others (row T3)

  [[nodiscard]] DeviceClock clock() const { return {clock_offset, drift}; }
  /// Cycles from a packet to the one its answer is for: the answer has to be there one cycle before.
  [[nodiscard]] int lead_cycles() const {
    const Nanoseconds there_and_back = 2 * wire.slowest();
    return static_cast<int>(std::max<Nanoseconds>(1, (there_and_back + cycle - 1) / cycle)) + 1;
  }
  /// Declared times of the agent of an arm.
  [[nodiscard]] device::AgentTiming timing(Nanoseconds core_period) const {
    return {.core_period = core_period,
            .device_cycle = cycle,
            .lead_cycles = lead_cycles(),
            .margin = wire.jitter,
            .padding = padding};
  }
  /// Of its set points.
  [[nodiscard]] Nanoseconds delay(Nanoseconds core_period) const { return timing(core_period).delay(); }
  /// The first whole cycle of the device at or after the core's start.
  [[nodiscard]] std::int64_t first_cycle() const {
    std::int64_t first = clock_offset / cycle - 1;
    while (clock().to_core(first * cycle) < 0) ++first;
    return first;
  }
};

}  // namespace takt::emulation
