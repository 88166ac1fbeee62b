#pragma once

#include <atomic>
#include <chrono>

/// Ctrl-C while takt works without Python's lock: the first asks for an orderly end, the second stops at once.
namespace takt::python {

/// Counts what Python's signal handlers have raised. Thread: the one that runs Python's signals; elsewhere nothing is
/// counted. Realtime: setup.
class Interrupts {
 public:
  /// Lets Python look at its signals, 50 times a second at most. Call it without Python's lock.
  void poll();
  [[nodiscard]] const std::atomic<int>& count() const { return count_; }
  [[nodiscard]] bool any() const { return count_.load() > 0; }

 private:
  using Clock = std::chrono::steady_clock;
  std::atomic<int> count_ = 0;
  Clock::time_point looked_ = Clock::now();
};

}  // namespace takt::python
