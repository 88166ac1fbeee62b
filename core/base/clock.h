#pragma once

#include <atomic>
#include <ctime>

#include "core/base/time.h"

namespace takt {

/// Gives the core's time: the time of cycle k is k periods (row T1). What serves a device with a clock of its own reads
/// it, so that the same code runs on simulated time and on a machine's clock.
class Clock {
 public:
  /// One look at the clock. A core that is late leaves out time and goes on later: its time falls behind the machine's,
  /// which never jumps. Estimates of other clocks are made against `machine`; set points and samples carry `core`.
  struct Reading {
    Nanoseconds machine = 0;  ///< steady
    Nanoseconds skipped = 0;  ///< left out by the core so far
    [[nodiscard]] Nanoseconds core() const { return machine - skipped; }
  };

  virtual ~Clock() = default;
  /// Any thread. Realtime: cyclic.
  [[nodiscard]] virtual Reading read() const = 0;
  /// The core's time. Any thread. Realtime: cyclic.
  [[nodiscard]] Nanoseconds now() const { return read().core(); }
};

/// Time that someone sets: lock-step. One thread.
class VirtualClock final : public Clock {
 public:
  [[nodiscard]] Reading read() const override { return {machine_, skipped_}; }
  /// `now` is the core's time.
  void set(Nanoseconds now) { machine_ = now + skipped_; }
  /// As MonotonicClock::skip().
  void skip(Nanoseconds time) { skipped_ += time; }

 private:
  Nanoseconds machine_ = 0, skipped_ = 0;
};

/// The machine's monotonic clock, counted from the origin of the core's time.
class MonotonicClock final : public Clock {
 public:
  /// The origin is now.
  MonotonicClock() : first_origin_(machine_time()), origin_(first_origin_) {}

  [[nodiscard]] Reading read() const override {
    // Acquired first: a skip that is seen has happened before the machine's time is read.
    const Nanoseconds skipped = origin_.load(std::memory_order_acquire) - first_origin_;
    return {machine_time() - first_origin_, skipped};
  }
  /// What Reading::machine is when machine_time() is this. Any thread. Realtime: cyclic.
  [[nodiscard]] Nanoseconds at(Nanoseconds machine_time) const { return machine_time - first_origin_; }
  /// The core's time is `core_time` when machine_time() is `machine`. Any thread.
  void align(Nanoseconds core_time, Nanoseconds machine) {
    origin_.store(machine - core_time, std::memory_order_release);
  }
  /// The core left out that much time: its cycles go on later than they were due; negative: earlier. Any thread.
  void skip(Nanoseconds time) { origin_.fetch_add(time, std::memory_order_acq_rel); }

  /// CLOCK_MONOTONIC. Any thread. Realtime: cyclic.
  [[nodiscard]] static Nanoseconds machine_time() {
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * kSecond + time.tv_nsec;
  }

 private:
  const Nanoseconds first_origin_;
  std::atomic<Nanoseconds> origin_;
};

}  // namespace takt
