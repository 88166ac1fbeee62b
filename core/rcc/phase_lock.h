#pragma once

#include <optional>

#include "core/base/time.h"
#include "core/rcc/lateness_times.h"

namespace takt::rcc {

/// Lets the clock of one device pace the core (docs/time.md, "A device as the master"): the core's cycle begins half a
/// period after the device's packets come, and stays there however the two clocks drift. The correction of each cycle
/// is bounded, so nothing that the core's clock drives notices more than a speed that is off by kSlew. One thread.
/// Realtime: cyclic, O(1).
class PhaseLock {
 public:
  /// As much as agents of devices make up for in the same time (ArmAgent::kSlew): more would empty their rings.
  static constexpr double kSlew = 200e-6;

  /// @param period  of the core, > 0; cycles of the device are whole multiples of it
  explicit PhaseLock(Nanoseconds period);

  /// @param due  when the next cycle of the core is to begin @param packet  when some packet of the device came, or
  /// would have come without jitter; on the same clock. Null: the device is silent, and the core's clock runs on.
  /// @return by how much that cycle has to begin later, ns; negative: earlier
  [[nodiscard]] Nanoseconds correction(Nanoseconds due, std::optional<Nanoseconds> packet);

  /// How far from the middle between two instants of packets the cycles were due, since the lock first was within
  /// kLocked; empty before.
  [[nodiscard]] const LatenessTimes& off() const { return off_; }

 private:
  static constexpr Nanoseconds kLocked = 20'000;

  Nanoseconds period_, most_;
  bool locked_ = false;
  LatenessTimes off_;
};

}  // namespace takt::rcc
