#pragma once

#include <atomic>
#include <ctime>

#include "core/base/time.h"

namespace takt {

/// Tells the time on the core's clock: the time of cycle k is k periods (row T1). What serves a device with a clock of
/// its own asks it, so that the same code runs on simulated time and on a machine's clock.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Any thread. Realtime: cyclic.
  [[nodiscard]] virtual Nanoseconds now() const = 0;
};

/// Time that someone sets: lock-step.
class VirtualClock final : public Clock {
 public:
  [[nodiscard]] Nanoseconds now() const override { return now_; }
  void set(Nanoseconds now) { now_ = now; }

 private:
  Nanoseconds now_ = 0;
};

/// The machine's monotonic clock, counted from the origin of the core's time.
class MonotonicClock final : public Clock {
 public:
  /// The origin is now.
  MonotonicClock() : origin_(machine_time()) {}

  [[nodiscard]] Nanoseconds now() const override { return machine_time() - origin_.load(std::memory_order_relaxed); }
  /// The core left out that much time: its cycles go on later than they were due. Any thread.
  void skip(Nanoseconds time) { origin_.fetch_add(time, std::memory_order_relaxed); }

 private:
  static Nanoseconds machine_time() {
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * kSecond + time.tv_nsec;
  }

  std::atomic<Nanoseconds> origin_;
};

}  // namespace takt
