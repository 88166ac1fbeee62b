#include "serve/watched_run.h"

#include <utility>

#include "cell/build/site_devices.h"

namespace takt::serve {
namespace {

constexpr std::size_t kEventsOfACycle = 4096;

}  // namespace

WatchedRun::WatchedRun(cell::Session& session, cell::RunOptions& options)
    : beside_loop_(options.realtime), desk_(!options.realtime, options.interrupt) {
  pending_.reserve(kEventsOfACycle);
  begin(session.description(), session.built());
  desk_.set_planned(session.planned_duration());
  take_up_pace();
  add_hooks(options);
  publisher_ = std::jthread([this](const std::stop_token& stop) { publish_news(stop); });
}

WatchedRun::~WatchedRun() {
  publisher_.request_stop();
  ++news_;
  news_.notify_all();
}

void WatchedRun::add_hooks(cell::RunOptions& options) {
  options.after_cycle = [this, before = std::move(options.after_cycle)](cell::BuiltCell& built) {
    const bool going = !before || before(built);
    after_cycle();
    return going;
  };
  options.operate = [this, before = std::move(options.operate)](cell::Operator& panel) {
    if (before) before(panel);
    connected_ = true;  // a program is advanced only once all devices are there
    desk_.operate(panel);
  };
  options.tell = [this, before = std::move(options.tell)](const cell::LogEntry& entry) {
    if (before) before(entry);
    desk_.heard(entry);
  };
  if (beside_loop_) return;
  options.before_step = [this](const cell::NextStep& next) {
    const auto answer = desk_.before_step(next, [this] {
      ++news_;
      news_.notify_one();
    });
    take_up_pace();
    return answer;
  };
}

void WatchedRun::stop_all(const std::string& by) {
  ServedCell::stop_all(by);
  desk_.abort();
}

void WatchedRun::after_cycle() {
  const auto events = core().events();
  pending_.insert(pending_.end(), events.begin(), events.end());
  if (const std::unique_lock lock(fresh_mutex_, std::try_to_lock); lock.owns_lock()) {
    copy(pending_);
    pending_.clear();
  }
  lease().after_cycle();
  ++news_;
  news_.notify_one();
  if (!beside_loop_ && !built().site->own_clock()) keep_pace();
}

/// The core's time goes on from where it is.
void WatchedRun::take_up_pace() { start_ = WallClock::now() - std::chrono::nanoseconds(core().time()); }

/// What is late is counted and not caught up.
void WatchedRun::keep_pace() {
  const auto due = start_ + std::chrono::nanoseconds(core().time());
  const std::chrono::nanoseconds late = WallClock::now() - due;
  if (late.count() <= 0) return std::this_thread::sleep_until(due);
  const auto cycles = late / std::chrono::nanoseconds(period());
  count_late(cycles);
  start_ += cycles * std::chrono::nanoseconds(period());
}

void WatchedRun::publish_news(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const std::uint32_t seen = news_;
    {
      const std::lock_guard lock(fresh_mutex_);
      publish();
    }
    news_.wait(seen);
  }
}

void WatchedRun::ended(const cell::RunReport& report) {
  desk_.ended(report);
  ++news_;
  news_.notify_one();
}

}  // namespace takt::serve
