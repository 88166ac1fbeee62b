#pragma once

#include <chrono>
#include <cstdint>

#include "core/rcc/statistics.h"

namespace takt::rcc {

/// Measures the phases of one cycle into the statistics; does nothing unless asked to. Realtime: cyclic.
class Stopwatch {
 public:
  Stopwatch(Statistics& statistics, bool measure) : statistics_(statistics), measure_(measure) {
    if (measure_) begin_ = last_ = Clock::now();
  }
  ~Stopwatch() {
    if (!measure_) return;
    const std::int64_t total = nanoseconds(last_ - begin_);
    ++statistics_.measured_cycles;
    statistics_.total_ns += total;
    if (total > statistics_.max_ns) statistics_.max_ns = total;
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

  /// The time since the last call belongs to `phase`.
  void lap(CyclePhase phase) {
    if (!measure_) return;
    const auto now = Clock::now();
    statistics_.phase_ns[static_cast<std::size_t>(phase)] += nanoseconds(now - last_);
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static std::int64_t nanoseconds(Clock::duration duration) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(duration).count();
  }
  Statistics& statistics_;
  bool measure_;
  Clock::time_point begin_, last_;
};

}  // namespace takt::rcc
