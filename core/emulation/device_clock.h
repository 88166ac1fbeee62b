#pragma once

#include <cmath>

#include "core/base/time.h"

namespace takt::emulation {

/// A clock that does not run like the core's: it shows `offset` when the core's shows 0, and `drift` s more per second
/// (100 ppm = 1e-4). Realtime: cyclic.
class DeviceClock {
 public:
  DeviceClock() = default;
  DeviceClock(Nanoseconds offset, double drift) : offset_(offset), rate_(1.0 + drift) {}

  [[nodiscard]] Nanoseconds to_device(Nanoseconds core_time) const {
    return offset_ + std::llround(static_cast<double>(core_time) * rate_);
  }
  [[nodiscard]] Nanoseconds to_core(Nanoseconds device_time) const {
    return std::llround(static_cast<double>(device_time - offset_) / rate_);
  }

 private:
  Nanoseconds offset_ = 0;
  double rate_ = 1.0;
};

}  // namespace takt::emulation
