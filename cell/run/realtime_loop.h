#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "core/activity/planning_thread.h"
#include "core/activity/scheduler.h"
#include "core/base/priority_mutex.h"
#include "core/rcc/control_core.h"
#include "core/rcc/realtime_clock.h"

namespace takt::cell {

/// Runs a core in real time beside its program (docs/realtime.md): the cycle on a thread of its own, which nothing
/// waits for; the program on the caller's, between cycles; what takes long on a planning thread. One run.
class RealtimeLoop {
 public:
  struct Options {
    int priority = 80;        ///< of SCHED_FIFO for the cycle; 0: leave the scheduling alone
    bool lock_memory = true;  ///< no page of the process leaves memory
    int processor = -1;       ///< the only one that the cycle runs on; -1: any
    int overrun_limit = 5;    ///< RealtimeClock::Options; INT_MAX: overruns are only counted
    std::function<Nanoseconds(Nanoseconds due)> pace = {};  ///< likewise
  };
  /// @param time  the core's time, for the agents of its devices; it is kept from run() on. Both outlive the loop.
  RealtimeLoop(rcc::ControlCore& core, MonotonicClock& time, const Options& options);
  ~RealtimeLoop();

  /// What the program's scheduler needs.
  [[nodiscard]] const activity::RealtimeSupport& support() const { return support_; }

  struct Work {
    /// After each cycle, on its thread, under the lock. @return false: the run has to end. Realtime: cyclic.
    std::function<bool()> after_cycle;
    /// Between two cycles, on the caller's thread, under the lock: as soon as a cycle has ended that it has not seen.
    /// @return false: the program is over
    std::function<bool()> program;
    /// The same without the lock: for what may wait (a terminal, a film).
    std::function<void()> outside;
  };
  struct Report {
    rcc::RealtimeClock::Granted granted;
    rcc::LatenessTimes wakeups, begins;  ///< RealtimeClock::wakeups(), begins()
    std::int64_t events_lost = 0;        ///< of the core, that the program looked for too late
    std::int64_t cycles_unseen = 0;      ///< that began before the program had looked at the one before
  };
  /// Returns when the program is over, when after_cycle() says so, or when the clock has failed.
  Report run(const Work& work);

  // -- The same for a program that is not called, but calls: all on one thread, which has the lock from start() to
  // stop() but where something else is said.
  /// @param after_cycle  as of Work
  void start(std::function<bool()> after_cycle);
  /// Forgets what was seen, and waits, without the lock, for a cycle that was not. @return false: there are no more
  [[nodiscard]] bool next();
  /// Work that takes long, without the lock.
  void beside(const std::function<void()>& work);
  /// Ends the cycles; nothing happens if they have not begun.
  Report stop();

 private:
  void end_of_cycle();
  [[nodiscard]] bool wait_for_cycle();

  rcc::ControlCore& core_;
  Options options_;
  PriorityMutex lock_;
  rcc::RealtimeClock clock_;
  std::vector<rcc::Event> events_;  ///< since the program looked last
  Report report_;
  std::function<bool()> after_cycle_;
  std::atomic<std::int64_t> cycles_ = 0;  ///< that have ended
  std::int64_t last_ = 0;                 ///< of them, when the program looked last
  bool seen_ = true;                      ///< the program has looked at the last cycle
  bool going_ = true;                     ///< neither the program nor after_cycle() has said that it is over
  std::jthread cycle_;
  activity::PlanningThread planning_;
  activity::RealtimeSupport support_;
};

}  // namespace takt::cell
