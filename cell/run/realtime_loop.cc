#include "cell/run/realtime_loop.h"

#include <span>
#include <utility>

namespace takt::cell {
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

RealtimeLoop::~RealtimeLoop() { (void)stop(); }

void RealtimeLoop::end_of_cycle() {
  const std::span<const rcc::Event> news = core_.events();
  if (events_.size() + news.size() <= kMostEvents) {
    events_.insert(events_.end(), news.begin(), news.end());
  } else {
    report_.events_lost += static_cast<std::int64_t>(news.size());
  }
  if (!seen_) ++report_.cycles_unseen;
  seen_ = false;
  going_ = after_cycle_();
}

void RealtimeLoop::start(std::function<bool()> after_cycle) {
  after_cycle_ = std::move(after_cycle);
  lock_.lock();
  cycle_ = std::jthread([this](std::stop_token stop) {
    report_.granted = clock_.run(core_, std::move(stop), [this](rcc::ControlCore&) {
      if (going_) end_of_cycle();
      if (!going_) cycle_.request_stop();
      cycles_.fetch_add(1);
      cycles_.notify_one();
    });
    cycles_.store(kEnded);
    cycles_.notify_one();
  });
}

bool RealtimeLoop::wait_for_cycle() {
  if (!going_ || last_ == kEnded) return false;
  if (seen_) {
    lock_.unlock();
    cycles_.wait(last_);
    lock_.lock();
  }
  last_ = cycles_.load();
  seen_ = true;
  return going_ && last_ != kEnded;
}

bool RealtimeLoop::next() {
  events_.clear();
  return wait_for_cycle();
}

void RealtimeLoop::beside(const std::function<void()>& work) {
  lock_.unlock();
  try {
    work();
  } catch (...) {
    lock_.lock();
    throw;
  }
  lock_.lock();
}

RealtimeLoop::Report RealtimeLoop::stop() {
  if (!cycle_.joinable()) return std::move(report_);
  going_ = false;
  cycle_.request_stop();
  lock_.unlock();
  cycle_.join();
  report_.wakeups = clock_.wakeups();
  report_.begins = clock_.begins();
  return std::move(report_);
}

RealtimeLoop::Report RealtimeLoop::run(const Work& work) {
  start(work.after_cycle);
  while (wait_for_cycle()) {
    if (!work.program()) break;
    events_.clear();
    if (work.outside) beside(work.outside);
  }
  return stop();
}

}  // namespace takt::cell
