#include "core/activity/activity.h"

namespace takt::activity {

void require(const RunPtr& run) {
  if (run->state() == RunState::kFailed) throw ActivityError(run->diagnostics());
}

RunPtr Activity::begin_execute() const {
  runtime_->require_outside();
  RunPtr run = schedule();
  runtime_->run_until([&run] { return run->started(); });
  require(run);
  return run;
}

RunPtr Activity::execute() const {
  runtime_->require_outside();
  return wait(*runtime_, schedule());
}

RunPtr wait(Runtime& runtime, RunPtr run) {
  runtime.run_until([&run] { return run->over(); });
  require(run);
  return run;
}

RunPtr Activity::Awaiter::await_resume() const {
  when_.await_resume();
  require(run_);
  return run_;
}

Activity::Awaiter Activity::operator co_await() const { return {*runtime_, schedule(), true}; }

Activity::Awaiter started(const Activity& activity) { return {activity.runtime(), activity.schedule(), false}; }

Activity::Awaiter ended(Runtime& runtime, RunPtr run) { return {runtime, std::move(run), true}; }

}  // namespace takt::activity
