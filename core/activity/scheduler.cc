#include "core/activity/scheduler.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include <fmt/format.h>

#include "core/command/cause_text.h"

namespace takt::activity {
namespace {

using rcc::NetState;

constexpr const char* kAgain = "ask for it again when the cause is removed";

Diagnostics single_diagnostic(Code code, std::string message, std::string hint) {
  Diagnostics diagnostics;
  diagnostics.error(code, "", std::move(message), std::move(hint));
  return diagnostics;
}

Diagnostics given_up(const std::string& name, const std::string& before, const char* what) {
  return single_diagnostic(Code::kStopped, fmt::format("'{}' was given up: '{}' before it {}", name, before, what),
                           "nothing starts by itself after a stop: ask for it again");
}

}  // namespace

RunPtr Scheduler::schedule(ActivityPtr model) {
  RunPtr run = std::make_shared<ActivityRun>(core_, std::move(model));
  run->asked_cycle_ = core_.cycle();
  run->due_cycle_ = core_.cycle() + latency_cycles_;
  run->alone_ = alone_;
  runs_.push_back(run);
  return run;
}

void Scheduler::poll() {
  const std::vector<RunPtr> now = runs_;  // the list may change below
  for (const RunPtr& run : now) follow(*run);
  for (const bool avoids : {false, true})
    for (const RunPtr& run : now)
      if (run->model_->avoids_others() == avoids) prepare(run);
  for (const RunPtr& run : now) try_start(*run);
  for (const RunPtr& run : runs_) {
    if (run->over()) reactions_.insert(reactions_.end(), run->reactions().begin(), run->reactions().end());
  }
  std::erase_if(runs_, [](const RunPtr& run) { return run->over(); });
}

void Scheduler::cancel() {
  for (const RunPtr& run : runs_) run->cancel();
}

std::string Scheduler::current() const {
  std::string names;
  for (const RunPtr& run : runs_) {
    const bool runs = run->state() == RunState::kRunning || run->state() == RunState::kReturning;
    if (runs && !run->carries()) names += (names.empty() ? "" : " + ") + run->name();
  }
  return names;
}

std::set<std::string, std::less<>> Scheduler::touching() const {
  std::set<std::string, std::less<>> devices;
  for (const RunPtr& run : runs_) {
    const bool runs = run->state() == RunState::kRunning || run->state() == RunState::kReturning;
    if (runs) devices.insert(run->planned_.touching.begin(), run->planned_.touching.end());
  }
  return devices;
}

void Scheduler::apply(ActivityRun& run, RunEvent event) {
  const auto next = next_state(run.state_, event);
  if (!next) {
    fmt::print(stderr, "'{}' is {}, and \"{}\" cannot happen then\n", run.name(), name_of(run.state_), name_of(event));
    std::abort();
  }
  run.state_ = *next;
  run.began_ = run.began_ || *next == RunState::kRunning;
}

// -- What happened ----------------------------------------------------------------------------------------------------

void Scheduler::follow(ActivityRun& run) {
  switch (run.state_) {
    case RunState::kQueued:
      if (run.wants_cancel_) finish(run, RunEvent::kCancelled);
      return;
    case RunState::kLoaded:
      return follow_loaded(run);
    case RunState::kSwitching:
      return follow_switching(run);
    case RunState::kRunning:
      return run.change_ ? follow_switching(run) : follow_running(run);
    case RunState::kReturning:
      return follow_returning(run);
    default:
      return;  // it has failed with one before it in the list
  }
}

void Scheduler::follow_loaded(ActivityRun& run) {
  // Its start may have been carried out in the last cycle.
  const NetState net = run.net_ != 0 ? core_.state(run.net_) : NetState::kReady;
  if (run.wants_cancel_ && net <= NetState::kReady) return end(run, RunEvent::kCancelled);
  if (poll_answer(run) || net <= NetState::kReady) return;
  apply(run, RunEvent::kBegan);
  follow_running(run);
}

bool Scheduler::poll_answer(ActivityRun& run) {
  if (run.request_ == 0) return false;
  for (const rcc::Event& event : events()) {
    if (event.request != run.request_ || event.kind == rcc::Event::Kind::kState) continue;
    if (event.kind == rcc::Event::Kind::kRefused) {
      fail(run, RunFailure::kRefused,
           single_diagnostic(Code::kNotPossibleNow,
                             fmt::format("'{}' was not started: {}", run.name(), event.cause.text.view()), kAgain));
      return true;
    }
    run.blended_ = !run.planned_.taken_over.empty() && event.cause.text.size == 0;
  }
  return false;
}

/// A change that has begun comes to its end, whoever cancels meanwhile.
void Scheduler::follow_switching(ActivityRun& run) {
  if (!run.change_->poll(events())) return;
  Diagnostics diagnostics = run.change_->diagnostics();
  run.change_.reset();
  if (diagnostics.has_errors()) return fail(run, RunFailure::kModeRefused, std::move(diagnostics));
  if (run.wants_cancel_) return end(run, RunEvent::kCancelled);
  if (run.state_ == RunState::kRunning) return end(run, RunEvent::kEnded);  // it was nothing but this change
  apply(run, RunEvent::kSwitched);
}

void Scheduler::follow_running(ActivityRun& run) {
  if (run.carrier_ != nullptr) return follow_carried(run);
  const NetState state = core_.state(run.net_);
  run.after_cycle();
  run.call_externals();
  if (run.wants_cancel_ && state == NetState::kRunning) (void)core_.cancel(run.net_);  // again, if the queue is full
  if (state == NetState::kTerminated) end_of_net(run);
}

void Scheduler::follow_carried(ActivityRun& run) {
  ActivityRun& by = *run.carrier_;
  const bool is_cancelled = by.state_ == RunState::kCancelled || run.wants_cancel_;
  if (by.over() && by.state_ != RunState::kCompleted && is_cancelled) return end(run, RunEvent::kCancelled);
  if (by.state_ == RunState::kFailed)
    return fail(run, RunFailure::kStopped,
                single_diagnostic(Code::kStopped,
                                  fmt::format("'{}' was stopped on its path: '{}', which went on with it, failed",
                                              run.name(), by.name()),
                                  kAgain));
  if (!by.carries(run)) return end(run, RunEvent::kEnded);
  if (!run.wants_cancel_ || by.wants_cancel_) return;
  by.cancelled_with_ = run.name();
  by.cancel();
}

/// Once its arms are at rest: what failed brakes first.
void Scheduler::follow_returning(ActivityRun& run) {
  if (!run.change_) return begin_return(run);
  if (!run.change_->poll(events())) return;
  Diagnostics diagnostics = run.change_->diagnostics();
  run.change_.reset();
  if (diagnostics.has_errors()) return fail(run, RunFailure::kModeRefused, std::move(diagnostics));
  finish(run, run.outcome_);
}

// -- To the start -----------------------------------------------------------------------------------------------------

void Scheduler::try_plan(ActivityRun& run) {
  auto planned = planner_.try_plan(run, runs_);
  if (!planned) return fail(run, planned.error().failure, std::move(planned.error().diagnostics));
  if (*planned) apply(run, RunEvent::kPlanned);
}

void Scheduler::try_start(ActivityRun& run) {
  if (held_ || run.state_ != RunState::kLoaded || core_.cycle() < run.due_cycle_) return;
  if (!run.planned_.modes.empty() && run.modes_before_.empty()) {
    run.change_.emplace(core_, run.planned_.modes);
    run.modes_before_ = run.change_->before();
    return apply(run, run.net_ != 0 ? RunEvent::kSwitchAsked : RunEvent::kBegan);
  }
  if (run.rule_) post(run);  // else it was posted
}

/// The queue of the core may be full of requests of others: then it is posted again in the next cycle.
void Scheduler::post(ActivityRun& run) {
  run.request_ = core_.post(*run.rule_);
  if (run.request_ != 0) return run.rule_.reset();
  if (run.queue_full_since_ < 0) run.queue_full_since_ = core_.cycle();
  if (core_.cycle() - run.queue_full_since_ < rcc::Rule::kAnswerTimeout) return;
  fail(
      run, RunFailure::kRefused,
      single_diagnostic(Code::kNotPossibleNow,
                        fmt::format("'{}' was not started: the control core's queue of requests was full for {} cycles",
                                    run.name(), rcc::Rule::kAnswerTimeout),
                        "fewer requests in one cycle"));
}

// -- The end ----------------------------------------------------------------------------------------------------------

void Scheduler::end_of_net(ActivityRun& run) {
  run.status_ = core_.status(run.net_);
  const net::Cause& cause = run.status_->cause;
  if (cause.code == net::Cause::Code::kCancelled && !run.cancelled_with_.empty()) {
    run.taken_ = true;  // whoever asks for a cancel knows what was to follow
    return fail(run, RunFailure::kGivenUp, given_up(run.name(), run.cancelled_with_, "was cancelled"));
  }
  if (cause.code == net::Cause::Code::kCancelled) return end(run, RunEvent::kCancelled);
  if (cause.code == net::Cause::Code::kTakenOver && (run.carrier_ = successor_of(run)) != nullptr)
    return follow_carried(run);
  if (cause.in_order()) {
    Diagnostics wrong = run.planned_.verdict ? run.planned_.verdict(run) : Diagnostics();
    if (wrong.has_errors()) return fail(run, RunFailure::kAborted, std::move(wrong));
    return end(run, RunEvent::kEnded);
  }
  fail(run, RunFailure::kStopped,
       single_diagnostic(Code::kStopped,
                         fmt::format("'{}' was stopped in cycle {} ({}): {}", run.name(), run.status_->last_cycle,
                                     net::name_of(cause.code), command::cause_text(cause, cell_)),
                         kAgain));
}

RunPtr Scheduler::successor_of(const ActivityRun& run) const {
  const auto next = std::ranges::find_if(runs_, [&](const RunPtr& other) {
    const bool goes_on =
        !other->planned_.taken_over.empty() && other->net_ != 0 && other->carrier_ == nullptr && !other->over();
    return goes_on && other.get() != &run && other->shares_actuator(run) && core_.state(other->net_) > NetState::kReady;
  });
  return next == runs_.end() ? nullptr : *next;
}

void Scheduler::fail(ActivityRun& run, RunFailure why, Diagnostics diagnostics) {
  if (run.failure_ == RunFailure::kNone) run.failure_ = why;
  // Each location begins with the activity, as the paths of commands do.
  const std::string own = pointer_segment(run.name());
  for (Diagnostic diagnostic : diagnostics.list()) {
    if (!diagnostic.pointer.starts_with(own)) diagnostic.pointer.insert(0, own);
    run.diagnostics_.add(std::move(diagnostic));
  }
  end(run, RunEvent::kFailed);
}

/// An arm does not stay compliant, not even after a failure.
void Scheduler::end(ActivityRun& run, RunEvent outcome) {
  if (!run.must_return() || run.state_ == RunState::kReturning) return finish(run, outcome);
  apply(run, RunEvent::kReturnAsked);
  run.outcome_ = outcome;
  run.rule_.reset();
  begin_return(run);
}

void Scheduler::begin_return(ActivityRun& run) {
  const bool brakes = std::ranges::any_of(run.modes_before_, [this](const auto& before) {
    const device::Arm* arm = core_.find_arm(before.first);
    return arm != nullptr && is_busy(*arm);
  });
  if (!brakes) run.change_.emplace(core_, run.modes_before_);
}

void Scheduler::finish(ActivityRun& run, RunEvent outcome) {
  apply(run, outcome);
  if (outcome == RunEvent::kEnded) return;
  if (outcome == RunEvent::kFailed || !run.began_) run.unload();
  give_up_followers(run);
}

void Scheduler::give_up_followers(const ActivityRun& run) {
  bool behind = false;
  for (const RunPtr& other : runs_) {
    if (other.get() == &run) behind = true;
    if (!behind || other.get() == &run || !is_waiting(other->state()) || !other->shares_actuator(run)) continue;
    // Whoever asks for a cancel knows what was to follow.
    other->taken_ = run.state_ == RunState::kCancelled || (run.failure_ == RunFailure::kGivenUp && run.taken_);
    fail(*other, RunFailure::kGivenUp,
         given_up(other->name(), run.name(), run.state() == RunState::kCancelled ? "was cancelled" : "failed"));
  }
}

}  // namespace takt::activity
