#include "scenario/realtime_loop.h"

#include <mutex>
#include <span>
#include <thread>

namespace takt::scenario {
namespace {

constexpr std::size_t kMostEvents = 8192;  // a program that plans nothing itself is never that far behind
constexpr std::int64_t kEnded = -1;

}  // namespace

RealtimeLoop::RealtimeLoop(rcc::ControlCore& core, MonotonicClock& time, const Options& options)
    : core_(core),
      options_(options),
      clock_({.priority = options.priority,
              .lock_memory = options.lock_memory,
              .processor = options.processor,
              .overrun_limit = options.overrun_limit,
              .lock = &lock_,
              .time = &time,
              .pace = options.pace}),
      support_{.planning = &planning_, .events = &events_} {
  events_.reserve(kMostEvents);
}

bool RealtimeLoop::end_of_cycle(const Work& work) {
  const std::span<const rcc::Event> news = core_.events();
  if (events_.size() + news.size() <= kMostEvents) {
    events_.insert(events_.end(), news.begin(), news.end());
  } else {
    report_.events_lost += static_cast<std::int64_t>(news.size());
  }
  if (!seen_) ++report_.cycles_unseen;
  seen_ = false;
  return work.after_cycle();
}

RealtimeLoop::Report RealtimeLoop::run(const Work& work) {
  std::stop_source stop;
  bool going = true;  // under the lock
  std::jthread cycle([&] {
    report_.granted = clock_.run(core_, stop.get_token(), [&](rcc::ControlCore&) {
      if (going && !end_of_cycle(work)) {
        going = false;
        stop.request_stop();
      }
      cycles_.fetch_add(1);
      cycles_.notify_one();
    });
    cycles_.store(kEnded);
    cycles_.notify_one();
  });
  for (std::int64_t seen = 0;;) {
    cycles_.wait(seen);
    {
      const std::lock_guard lock(lock_);
      seen = cycles_.load();
      if (!going || seen == kEnded) break;
      seen_ = true;
      going = work.program();
      events_.clear();
      if (!going) break;
    }
    if (work.outside) work.outside();
  }
  stop.request_stop();
  cycle.join();
  report_.wakeups = clock_.wakeups();
  report_.begins = clock_.begins();
  return std::move(report_);
}

}  // namespace takt::scenario
