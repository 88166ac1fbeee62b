#include "core/rcc/phase_lock.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace takt::rcc {

PhaseLock::PhaseLock(Nanoseconds period) : period_(period), most_(std::llround(kSlew * static_cast<double>(period))) {}

Nanoseconds PhaseLock::correction(Nanoseconds due, std::optional<Nanoseconds> packet) {
  if (!packet) return 0;
  // 0 at a packet, half a period where the cycle should be.
  const Nanoseconds phase = ((due - *packet) % period_ + period_) % period_;
  const Nanoseconds error = phase - period_ / 2;
  locked_ = locked_ || std::abs(error) <= kLocked;
  if (locked_) off_.add(std::abs(error));
  return std::clamp(-error, -most_, most_);
}

}  // namespace takt::rcc
