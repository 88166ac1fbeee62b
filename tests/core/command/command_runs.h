#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/activity/command_activity.h"
#include "core/activity/scheduler.h"

/// Commands of a test, run by the scheduler of activities like those of any program, but started when the test says so.
namespace takt::test {

/// How a command is.
struct CommandStatus {
  activity::RunState state = activity::RunState::kQueued;
  net::Cause cause;  ///< of the end of its net; code kNone before, and of one that never began
  std::int64_t first_cycle = -1, last_cycle = -1;
  Diagnostics diagnostics;                         ///< of one that failed
  std::vector<activity::TracedCycle> last_cycles;  ///< of one that failed while it ran

  [[nodiscard]] bool ended() const { return activity::is_final(state); }
  [[nodiscard]] bool succeeded() const { return ended() && state != activity::RunState::kFailed; }
  [[nodiscard]] std::string to_string() const {
    std::string text = fmt::format("{} in cycle {}: {}\n{}", net::name_of(cause.code), last_cycle, cause.text.view(),
                                   diagnostics.to_string());
    for (const activity::TracedCycle& one : last_cycles) {
      text += fmt::format("\n  {}:", one.cycle);
      for (const auto& [name, value] : one.values) text += fmt::format(" {}={}", name, value);
    }
    return text;
  }
};

/// A command that is planned and loaded, or waits for its arms to come to rest. Copies are the same.
class LoadedCommand {
 public:
  LoadedCommand(std::shared_ptr<activity::Scheduler> scheduler, activity::RunPtr run, std::function<void()> step)
      : scheduler_(std::move(scheduler)), run_(std::move(run)), step_(std::move(step)) {}

  /// Begins in the next cycle.
  void start() {
    scheduler_->hold(false);
    scheduler_->poll();
  }
  void cancel() {
    run_->cancel();
    scheduler_->poll();
  }
  void abort() { run_->abort(); }
  /// Runs cycles until it has ended, or so many.
  CommandStatus wait(std::int64_t most_cycles = 60'000) {
    for (std::int64_t i = 0; i < most_cycles && !status().ended(); ++i) step_();
    return status();
  }
  [[nodiscard]] CommandStatus status() {
    scheduler_->poll();
    CommandStatus status{.state = run_->state(),
                         .cause = run_->cause(),
                         .first_cycle = run_->first_cycle(),
                         .last_cycle = run_->last_cycle(),
                         .diagnostics = run_->diagnostics(),
                         .last_cycles = {}};
    if (run_->state() == activity::RunState::kFailed) status.last_cycles = run_->last_cycles();
    return status;
  }
  template <class T>
  [[nodiscard]] std::optional<T> value(const std::string& name) const {
    return run_->value<T>(name);
  }
  [[nodiscard]] rcc::NetId net() const { return run_->net(); }
  [[nodiscard]] const activity::RunPtr& run() const { return run_; }
  void poll() { scheduler_->poll(); }

 private:
  std::shared_ptr<activity::Scheduler> scheduler_;
  activity::RunPtr run_;
  std::function<void()> step_;
};

/// Loads commands into a core. One scheduler for each: they know nothing of each other, and the core itself decides.
class CommandRuns {
 public:
  CommandRuns(rcc::ControlCore& core, const expression::Cell& cell, std::function<void()> cycle = {})
      : core_(core), cell_(cell), cycle_(cycle ? std::move(cycle) : [&core] { core.step(); }) {}

  /// Plans, checks, maps, verifies. Nothing moves. @return all diagnostics, if it is refused
  [[nodiscard]] Result<LoadedCommand> load(const command::Command& command) {
    auto scheduler =
        std::make_shared<activity::Scheduler>(core_, cell_, activity::Scheduler::Options{.latency_cycles = 0});
    const activity::RunPtr run = scheduler->schedule(activity::command_activity(command));
    scheduler->prepare(run);
    if (run->over()) return std::unexpected(run->diagnostics());
    scheduler->hold(true);
    LoadedCommand loaded(scheduler, run, [this] { step(); });
    loaded_.push_back(loaded);
    return loaded;
  }
  /// Loads, starts, and waits for its end.
  CommandStatus execute(const command::Command& command) {
    auto loaded = load(command);
    if (!loaded)
      return {.state = activity::RunState::kFailed, .cause = {}, .diagnostics = loaded.error(), .last_cycles = {}};
    loaded->start();
    return loaded->wait();
  }
  void step() {
    cycle_();
    poll();
  }
  void poll() {
    const auto all = loaded_;  // a handler may load another one
    for (LoadedCommand one : all) one.poll();
    std::erase_if(loaded_, [](const LoadedCommand& one) { return one.run()->over(); });
  }

 private:
  rcc::ControlCore& core_;
  const expression::Cell& cell_;
  std::function<void()> cycle_;
  std::vector<LoadedCommand> loaded_;
};

}  // namespace takt::test
