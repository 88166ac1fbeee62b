#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace takt::activity {

/// Does what takes long (planning, mapping, LOAD) beside the cycle and beside the program: a thread of its own that
/// takes one piece of work after the other. In lock-step there is none, and the thread of the program plans.
class PlanningThread {
 public:
  PlanningThread() = default;
  PlanningThread(const PlanningThread&) = delete;
  PlanningThread& operator=(const PlanningThread&) = delete;
  /// Waits for the work that has begun; forgets what has not.
  ~PlanningThread() = default;

  /// An exception that leaves `work` is reported on stderr. Any thread. Realtime: setup.
  void submit(std::function<void()> work);

 private:
  void run(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::deque<std::function<void()>> waiting_;
  std::jthread thread_{[this](const std::stop_token& stop) { run(stop); }};  // last: it uses the others
};

}  // namespace takt::activity
