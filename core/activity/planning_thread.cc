#include "core/activity/planning_thread.h"

#include <utility>

#include "core/base/last_catch.h"

namespace takt::activity {

void PlanningThread::submit(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(work));
  }
  wake_.notify_one();
}

void PlanningThread::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return !waiting_.empty(); })) {
    if (stop.stop_requested()) return;
    const auto work = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    (void)run_caught("plan an activity", work);
    lock.lock();
  }
}

}  // namespace takt::activity
