#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "core/base/clock.h"
#include "core/base/last_catch.h"
#include "core/base/priority_mutex.h"
#include "core/base/time.h"
#include "core/rcc/control_core.h"
#include "core/rcc/lateness_times.h"

namespace takt::rcc {

/// Runs a control core in real time: one step per period of the monotonic clock, with absolute wake-ups. The other
/// clock is lock-step: whoever owns the core calls step() as fast as he likes.
///
/// What the machine grants is taken: real-time scheduling and locked memory where permitted, else the clock runs
/// without and says so. A wake-up that is a whole period late or more skips the instants it missed, so cycles are late
/// but never bunched; each counts into a leaky counter. When that is full, all nets are stopped within their limits
/// (cause kOverrun).
///
/// It keeps the core's time: cycle k begins at k periods of time(), also after instants were skipped. The I/O agents of
/// its devices read that clock and no other, so that they agree with the set points' stamps.
class RealtimeClock {
 public:
  struct Options {
    int priority = 80;        ///< of SCHED_FIFO; 0: leave the scheduling alone
    bool lock_memory = true;  ///< no page of the process leaves memory
    int processor = -1;       ///< the only one that its thread runs on; -1: any
    int overrun_limit = 5;    ///< this many overruns, less one for each leak_cycles, stop the nets
    int leak_cycles = 1000;
    Nanoseconds watchdog = 100 * kMillisecond;  ///< a cycle that takes longer is stuck (Watchdog); 0: nobody watches
    Nanoseconds grace = 500 * kMillisecond;     ///< for the devices to stop, before the process ends
    PriorityMutex* lock = nullptr;              ///< held while a cycle runs: a program looks between cycles
    MonotonicClock* time = nullptr;             ///< to keep; null: the clock has one of its own
    /// By how much a cycle has to begin later that is due then (as Clock::Reading::machine has it); negative: earlier.
    /// Less than half a period. Called between cycles, on its thread; cyclic. Empty: cycles are a period apart.
    std::function<Nanoseconds(Nanoseconds due)> pace = {};
  };
  struct Granted {
    bool realtime_scheduling = false;
    bool locked_memory = false;
    int processor = -1;  ///< the only one that its thread runs on; -1: any
    /// Why it ended although nobody asked: what step() threw, and in which cycle. Empty: it was asked to end.
    std::string failure;
  };

  explicit RealtimeClock(const Options& options)
      : options_(options), time_(options.time != nullptr ? options.time : &own_time_) {}
  RealtimeClock(const RealtimeClock&) = delete;
  RealtimeClock& operator=(const RealtimeClock&) = delete;

  /// The core's time, for the agents of its devices; must outlive them. Any thread.
  [[nodiscard]] const Clock& time() const { return *time_; }
  /// How late its thread woke up: what the machine and its system cost. While it does not run, or under the lock.
  [[nodiscard]] const LatenessTimes& wakeups() const { return wakeups_; }
  /// How late its cycles began: the same, and what it waited for the lock.
  [[nodiscard]] const LatenessTimes& begins() const { return begins_; }

  /// Runs on the calling thread until `stop` is requested. `after_step` runs on it after each step and must be cyclic
  /// too; may be empty. No exception leaves it: one of after_step() is reported, stops all nets (cause kException) and
  /// the clock goes on; after one of step() itself nothing is known of the cycle, so the clock ends, the rings of the
  /// I/O agents run dry and the agents stop their devices. @return what was granted, and how it ended.
  Granted run(ControlCore& core, const std::stop_token& stop, const std::function<void(ControlCore&)>& after_step = {});

 private:
  Granted prepare_thread() const;
  /// A cycle and what follows it. @return false: the clock has to end
  bool run_cycle(ControlCore& core, Nanoseconds due, const std::function<void(ControlCore&)>& after_step,
                 std::string& failure);
  bool step(ControlCore& core, std::string& failure) const;
  void call_after_step(ControlCore& core, const std::function<void(ControlCore&)>& after_step);
  void count(ControlCore& core, std::int64_t late_cycles);

  Options options_;
  MonotonicClock own_time_;
  MonotonicClock* time_;
  LatenessTimes wakeups_, begins_;
  std::int64_t level_ = 0;  ///< of the leaky counter, in overruns * leak_cycles
  RareReport report_;       ///< of exceptions of after_step()
};

}  // namespace takt::rcc
