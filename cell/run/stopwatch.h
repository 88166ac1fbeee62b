#pragma once

#include <chrono>

namespace takt::cell {

/// Adds the wall time of its scope to a sum (s), if asked to measure.
class Stopwatch {
 public:
  using Clock = std::chrono::steady_clock;

  Stopwatch(bool on, double& sum) : sum_(on ? &sum : nullptr) {
    if (sum_) start_ = Clock::now();
  }
  ~Stopwatch() {
    if (sum_) *sum_ += seconds_since(start_);
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

  [[nodiscard]] static double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  }

 private:
  double* sum_;
  Clock::time_point start_;
};

}  // namespace takt::cell
