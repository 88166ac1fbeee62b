#pragma once

#include <array>
#include <memory>
#include <utility>

#include "core/activity/runtime.h"

namespace takt::activity {

/// An operation that a program may ask for, as often as it likes: robot.use<LinInterface>().lin(goal). A cheap value.
/// Thread: the program's. What goes wrong is thrown (ActivityError). Realtime: setup.
class Activity {
 public:
  Activity(Runtime& runtime, ActivityPtr model) : runtime_(&runtime), model_(std::move(model)) {}

  [[nodiscard]] const ActivityPtr& model() const { return model_; }
  [[nodiscard]] Runtime& runtime() const { return *runtime_; }

  /// Takes its turn behind what has its actuators already; returns at once.
  RunPtr schedule() const { return runtime_->schedule(model_); }
  /// Returns when it has really started, in motion if what runs may be left. @return its run, to wait for or to cancel
  RunPtr begin_execute() const;
  /// Returns when it has ended. Throws if it did not come to its end.
  RunPtr execute() const;

  /// co_await activity: as execute(), beside others. co_await started(activity): as begin_execute().
  class Awaiter;
  [[nodiscard]] Awaiter operator co_await() const;

 private:
  Runtime* runtime_;
  ActivityPtr model_;
};

/// Waits for a run in a coroutine.
class Activity::Awaiter {
 public:
  Awaiter(Runtime& runtime, RunPtr run, bool until_end)
      : run_(std::move(run)),
        when_(runtime.when([run = run_, until_end] { return until_end ? run->over() : run->started(); })) {}
  [[nodiscard]] bool await_ready() const { return when_.await_ready(); }
  void await_suspend(std::coroutine_handle<> handle) { when_.await_suspend(handle); }
  RunPtr await_resume() const;

 private:
  RunPtr run_;
  Runtime::When when_;
};

[[nodiscard]] Activity::Awaiter started(const Activity& activity);
/// The end of a run that was begun before.
[[nodiscard]] Activity::Awaiter ended(Runtime& runtime, RunPtr run);
/// Waits for the end of a run. Throws if it did not come to its end.
RunPtr wait(Runtime& runtime, RunPtr run);
/// Throws what made a run fail.
void require(const RunPtr& run);

}  // namespace takt::activity
