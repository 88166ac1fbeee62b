#include "core/rcc/watchdog.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>

#include <fmt/format.h>

#include "core/base/last_catch.h"

namespace takt::rcc {

Watchdog::Watchdog(const ControlCore& core, const Options& options)
    : core_(core), options_(options), thread_([this](const std::stop_token& stop) { watch(stop); }) {}

void Watchdog::watch(const std::stop_token& stop) const {
  using Clock = std::chrono::steady_clock;
  const std::chrono::nanoseconds limit(options_.limit);
  std::mutex mutex;
  std::condition_variable_any wake;
  std::unique_lock lock(mutex);
  std::int64_t seen = -1;
  Clock::time_point since = Clock::now();
  // Woken only by the request to stop; four looks within the limit keep the answer within a quarter of it.
  while (!wake.wait_for(lock, stop, limit / 4, [&stop] { return stop.stop_requested(); })) {
    const auto running = core_.running_cycle();
    const auto now = Clock::now();
    if (!running || *running != seen) {
      seen = running.value_or(-1);
      since = now;
    } else if (now - since >= limit) {
      Stall stall;
      (void)run_caught("find out what is stuck", [&] { stall = core_.where_it_is(); });
      end_process(stall);
    }
  }
}

void Watchdog::end_process(const Stall& stall) const {
  // Nothing of this may keep the process from its end.
  (void)run_caught("tell what is stuck", [&] {
    const std::string where =
        stall.net == 0 ? std::string("outside of all nets")
                       : fmt::format("in primitive '{}' of net {} ('{}')", stall.primitive, stall.net, stall.net_name);
    fmt::print(stderr,
               "takt: cycle {} has not ended for {} ms: it is stuck {}; the process ends, agents stop their devices\n",
               stall.cycle, options_.limit / kMillisecond, where);
  });
  if (options_.on_stall) (void)run_caught("write down a stall", [&] { options_.on_stall(stall); });
  std::this_thread::sleep_for(std::chrono::nanoseconds(options_.grace));
  std::_Exit(kExitStatus);
}

}  // namespace takt::rcc
