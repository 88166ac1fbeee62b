#include "core/activity/runtime.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/activity/motion_activity.h"

namespace takt::activity {

Runtime::Runtime(rcc::ControlCore& core, command::Cell& cell, std::function<void()> run_cycle, const Options& options)
    : core_(core),
      cell_(cell),
      run_cycle_(std::move(run_cycle)),
      options_(options),
      scheduler_(core, cell, options.scheduler) {}

ProgramCancelled::ProgramCancelled()
    : ActivityError([] {
        Findings why;
        why.error("", "the program was cancelled");
        return why;
      }()) {}

RunPtr Runtime::schedule(ActivityPtr model) {
  require_going();
  return scheduler_.schedule(std::move(model));
}

void Runtime::cancel() {
  cancelled_ = true;
  scheduler_.hold(false);  // held ones would never be given up
  scheduler_.cancel();
}

void Runtime::require_going() const {
  if (cancelled_) throw ProgramCancelled();
}

void Runtime::drop_coroutines() {
  waiting_.clear();
  spawned_.clear();
}

void Runtime::step() {
  resume_coroutines();
  scheduler_.poll();
  run_cycle_();
}

void Runtime::resume_coroutines() {
  // Those that can go on, one after the other, until all wait: in the order in which they began to.
  constexpr int kMostResumes = 10'000;  // in one step: more is a program that never waits (row D1)
  for (int resumed = 0;; ++resumed) {
    const bool ends = cancelled_ && scheduler_.idle();  // whatever they wait for: they hear that it is over
    const auto ready = std::ranges::find_if(waiting_, [ends](const Waiting& one) { return ends || one.holds(); });
    if (ready == waiting_.end()) break;
    if (resumed == kMostResumes) {
      Findings why;
      why.error("", fmt::format("the program went on {} times without a cycle between", kMostResumes));
      throw ActivityError(std::move(why));
    }
    const auto handle = ready->handle;
    waiting_.erase(ready);
    resuming_ = true;
    handle.resume();
    resuming_ = false;
  }
  look_at_spawned();
}

void Runtime::look_at_spawned() {
  for (auto task = spawned_.begin(); task != spawned_.end();) {
    if (!task->done()) {
      ++task;
      continue;
    }
    const Task ended = std::move(*task);
    task = spawned_.erase(task);
    ended.rethrow();
  }
}

void Runtime::run_until(const std::function<bool()>& holds) {
  Findings why;
  if (resuming_) {
    why.error("", "a coroutine may not block: the loop would stand", "co_await");
    throw ActivityError(std::move(why));
  }
  for (std::int64_t cycles = 0; !holds(); ++cycles) {
    if (cycles == options_.most_cycles) {
      why.error("", fmt::format("nothing came of it within {} cycles", cycles));
      throw ActivityError(std::move(why));
    }
    if (cancelled_ && scheduler_.idle() && waiting_.empty()) throw ProgramCancelled();
    step();
  }
  if (!cancelled_) return;
  while (!scheduler_.idle()) step();
  throw ProgramCancelled();
}

void Runtime::run(Task task) {
  resuming_ = true;
  task.begin();
  resuming_ = false;
  run_until([&task] { return task.done(); });
  task.rethrow();
}

void Runtime::spawn(Task task) {
  Task& kept = spawned_.emplace_back(std::move(task));
  const bool inside = std::exchange(resuming_, true);
  kept.begin();
  resuming_ = inside;
}

Runtime::When Runtime::cycles(std::int64_t count) {
  const std::int64_t until = core_.cycle() + count;
  return when([this, until] { return core_.cycle() >= until; });
}

void Runtime::set_speed(const std::string& arm, double rate) {
  speeds_[arm] = std::clamp(rate, 0.0, 1.0);
  write_speed(arm, speeds_.at(arm));
}

void Runtime::write_speed(const std::string& arm, double rate) {
  device::Channel* channel = core_.find_channel(speed_channel(arm));
  if (channel != nullptr) {
    channel->write(rate);
    return;
  }
  Findings why;
  why.error("", fmt::format("'{}' has no channel for its speed", arm), "declare_channels() before the first cycle");
  throw ActivityError(std::move(why));
}

Findings declare_channels(rcc::ControlCore& core, command::Cell& cell) {
  Findings findings;
  using Writer = device::ChannelDescription::Writer;
  const auto declare = [&](const device::ChannelDescription& description) {
    const std::string name = description.name;
    auto channel = core.declare(description);
    if (!channel) return findings.append(channel.error());
    cell.channels[name] = *channel;
  };
  for (const auto& [name, arm] : cell.arms) {
    const Nanoseconds two_cycles = 2 * core.period();
    declare({.name = path_time_channel(name), .writer = Writer::kNet, .unit = "s", .timeout = two_cycles});
    declare({.name = path_rate_channel(name), .writer = Writer::kNet, .unit = "1", .timeout = two_cycles});
    declare({.name = speed_channel(name), .unit = "1", .initial = net::Real{1.0}});
  }
  return findings;
}

}  // namespace takt::activity
