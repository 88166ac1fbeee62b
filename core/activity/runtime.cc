#include "core/activity/runtime.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/activity/held_parts.h"
#include "core/activity/motion_options.h"
#include "core/expression/moving_frames.h"
#include "core/expression/tool_settings.h"

namespace takt::activity {
namespace {

[[noreturn]] void throw_diagnostic(Code code, std::string place, std::string message, std::string hint) {
  Diagnostics why;
  why.error(code, std::move(place), std::move(message), std::move(hint));
  throw ActivityError(std::move(why));
}

}  // namespace

Runtime::Runtime(rcc::ControlCore& core, expression::Cell& cell, std::function<void()> run_cycle,
                 const Options& options)
    : core_(core),
      cell_(cell),
      run_cycle_(std::move(run_cycle)),
      options_(options),
      scheduler_(core, cell, options.scheduler, options.realtime),
      context_{.cell = cell,
               .core = core,
               .variables = options.variables != nullptr ? *options.variables : own_variables_,
               .program_latency_cycles = options.scheduler.latency_cycles,
               .event = options.event ? options.event : EventSink([](auto, auto, auto) {}),
               .scheduler = &scheduler_} {}

ProgramCancelled::ProgramCancelled()
    : ActivityError([] {
        Diagnostics why;
        why.error(Code::kCancelled, "", "the program was cancelled", "Make a new Runtime for what comes next");
        return why;
      }()) {}

RunPtr Runtime::schedule(ActivityPtr model) {
  require_going();
  if (options_.before_activity) {
    options_.before_activity(model->name());
    require_going();
  }
  expression::tell_tool_settings(cell_);  // what could not be told while something held the arm
  return begun_.emplace_back(scheduler_.schedule(std::move(model)));
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

void Runtime::require_outside() const {
  if (resuming_)
    throw_diagnostic(Code::kNotPossibleNow, "", "a coroutine must not block: it would stop the loop that runs it",
                     "co_await");
}

void Runtime::step() {
  require_outside();
  expression::update_flange_frames(cell_);
  resume_coroutines();
  report_failures();
  scheduler_.poll();
  notice_lost_parts(context_);
  notice_lost_tools(context_);
  run_cycle_();
}

void Runtime::resume_coroutines() {
  // Those that can go on, one after the other, until all wait: in the order in which they began to.
  for (;;) {
    const bool ends = cancelled_ && scheduler_.idle();  // whatever they wait for: they learn that it is over
    const auto ready = std::ranges::find_if(waiting_, [ends](const Waiting& one) { return ends || one.holds(); });
    if (ready == waiting_.end()) break;
    spend();
    const auto handle = ready->handle;
    waiting_.erase(ready);
    resuming_ = true;
    handle.resume();
    resuming_ = false;
  }
  poll_spawned();
}

void Runtime::report_failures() {
  std::erase_if(begun_, [this](const RunPtr& run) {
    if (!run->over()) return false;
    if (run->state_ != RunState::kFailed || run->taken_) return true;
    for (const Diagnostic& one : run->diagnostics_.list())
      context_.event(run->name(), "failed", fmt::format("{}: {}", name_of(one.code), one.message));
    failed_.push_back(run);
    return true;
  });
}

Diagnostics Runtime::take_failures(bool given_up) {
  report_failures();
  Diagnostics all;
  for (const RunPtr& run : failed_) {
    if (std::exchange(run->taken_, true)) continue;
    if (given_up || run->failure_ != RunFailure::kGivenUp) all.append(run->diagnostics_);
  }
  failed_.clear();
  return all;
}

void Runtime::spend() {
  constexpr int kMost = 10'000;  // in one cycle: more is a program that never waits
  if (std::exchange(spent_in_cycle_, core_.cycle()) != core_.cycle()) spent_ = 0;
  if (++spent_ > kMost)
    throw_diagnostic(Code::kTooLarge, "", fmt::format("the program resumed {} times without a cycle in between", kMost),
                     "co_await cycles(1), or an activity, in what repeats");
}

void Runtime::poll_spawned() {
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
  require_outside();
  for (std::int64_t cycles = 0; !holds(); ++cycles) {
    if (cycles == options_.most_cycles)
      throw_diagnostic(Code::kTimeout, "", fmt::format("not finished within {} cycles", cycles),
                       "a larger most_cycles, or a condition that comes true");
    if (cancelled_ && scheduler_.idle() && waiting_.empty()) throw ProgramCancelled();
    step();
  }
  if (!cancelled_) return;
  while (!scheduler_.idle()) step();
  throw ProgramCancelled();
}

void Runtime::run(Task task) {
  require_outside();
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
  if (!(rate >= 0.0 && rate <= 1.0))
    throw_diagnostic(Code::kOutOfRange, pointer_segment(arm), fmt::format("a speed of {:g}", rate), "from 0 to 1");
  write_speed(arm, rate);
  speeds_[arm] = rate;
}

void Runtime::write_speed(const std::string& arm, double rate) {
  device::Channel* channel = core_.find_channel(speed_channel(arm));
  if (channel != nullptr && options_.write_speed) return options_.write_speed(speed_channel(arm), rate);
  if (channel != nullptr) {
    channel->write(rate);
    return;
  }
  std::vector<std::string> names;
  for (const auto& [name, mounted] : cell_.arms) names.push_back(name);
  if (!cell_.arms.contains(arm))
    throw_diagnostic(Code::kUnknownName, pointer_segment(arm), fmt::format("there is no arm '{}'", arm),
                     nearest_choice(arm, names));
  throw_diagnostic(Code::kRequires, pointer_segment(arm), fmt::format("'{}' has no channel for its speed", arm),
                   "declare_channels() before the first cycle");
}

Diagnostics declare_channels(rcc::ControlCore& core, expression::Cell& cell) {
  Diagnostics diagnostics;
  using Writer = device::ChannelDescription::Writer;
  const auto declare = [&](const device::ChannelDescription& description) {
    const std::string name = description.name;
    auto channel = core.declare(description);
    if (!channel) return diagnostics.append(channel.error());
    cell.channels[name] = *channel;
  };
  for (const auto& [name, arm] : cell.arms) {
    const Nanoseconds two_cycles = 2 * core.period();
    declare({.name = path_time_channel(name), .writer = Writer::kNet, .unit = "s", .timeout = two_cycles});
    declare({.name = path_rate_channel(name), .writer = Writer::kNet, .unit = "1", .timeout = two_cycles});
    declare({.name = speed_channel(name), .unit = "1", .initial = net::Real{1.0}});
  }
  return diagnostics;
}

}  // namespace takt::activity
