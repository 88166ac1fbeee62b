#include "core/rcc/realtime_clock.h"

#include <algorithm>
#include <ctime>
#include <mutex>
#include <optional>

#include <fmt/format.h>
#include <pthread.h>
#include <sys/mman.h>

#include "core/base/processors.h"
#include "core/net/format_text.h"
#include "core/rcc/watchdog.h"

namespace takt::rcc {

namespace {

void sleep_until(Nanoseconds instant) {
  const timespec time{.tv_sec = instant / kSecond, .tv_nsec = instant % kSecond};
  // A signal may end the sleep early; then the rest is slept.
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) != 0) {
  }
}

}  // namespace

RealtimeClock::Granted RealtimeClock::prepare_thread() const {
  Granted granted;
  if (options_.priority > 0) {
    const sched_param parameters{.sched_priority = options_.priority};
    granted.realtime_scheduling = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
  }
  if (options_.processor >= 0 && run_on_processor(options_.processor)) granted.processor = options_.processor;
  if (options_.lock_memory) granted.locked_memory = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  return granted;
}

void RealtimeClock::count(ControlCore& core, std::int64_t late_cycles) {
  level_ = std::max<std::int64_t>(0, level_ - 1);
  if (late_cycles == 0) return;
  core.count_overruns(late_cycles);
  level_ += options_.leak_cycles;
  if (level_ < std::int64_t{options_.overrun_limit} * options_.leak_cycles) return;
  core.stop_all(net::Cause::Code::kOverrun, "the cycle was late too often");
  level_ = 0;
}

/// The last catch of the cycle. @return false after an exception
bool RealtimeClock::step(ControlCore& core, std::string& failure) const {
  try {
    core.step();
    return true;
  } catch (...) {
    const std::string task = fmt::format("run cycle {}", core.cycle());
    report_exception(task);
    failure = fmt::format("{}; while doing: {}", exception_text(), task);
    return false;
  }
}

void RealtimeClock::call_after_step(ControlCore& core, const std::function<void(ControlCore&)>& after_step) {
  try {
    after_step(core);
  } catch (...) {
    if (report_.next()) report_exception("what follows each cycle");
    core.stop_all(net::Cause::Code::kException,
                  net::format_text("what follows each cycle: {}", exception_text()).view());
  }
}

bool RealtimeClock::run_cycle(ControlCore& core, Nanoseconds due, const std::function<void(ControlCore&)>& after_step,
                              std::string& failure) {
  wakeups_.add(MonotonicClock::machine_time() - due);
  std::unique_lock<PriorityMutex> lock;
  if (options_.lock != nullptr) lock = std::unique_lock(*options_.lock);
  begins_.add(MonotonicClock::machine_time() - due);
  if (!step(core, failure)) return false;
  if (after_step) call_after_step(core, after_step);
  return true;
}

RealtimeClock::Granted RealtimeClock::run(ControlCore& core, const std::stop_token& stop,
                                          const std::function<void(ControlCore&)>& after_step) {
  Granted granted = prepare_thread();
  std::optional<Watchdog> watchdog;
  if (options_.watchdog > 0)
    watchdog.emplace(core, Watchdog::Options{.limit = options_.watchdog, .grace = options_.grace});
  const Nanoseconds period = core.period();
  Nanoseconds instant = MonotonicClock::machine_time();
  time_->align(core.time(), instant);
  while (!stop.stop_requested()) {
    if (!run_cycle(core, instant, after_step, granted.failure)) break;
    instant += period;
    const std::int64_t late_cycles = std::max<Nanoseconds>(0, MonotonicClock::machine_time() - instant) / period;
    instant += late_cycles * period;
    if (late_cycles > 0) time_->skip(late_cycles * period);
    count(core, late_cycles);
    if (options_.pace) {
      const Nanoseconds later = options_.pace(time_->at(instant));
      instant += later;
      time_->skip(later);
    }
    sleep_until(instant);
  }
  return granted;
}

}  // namespace takt::rcc
