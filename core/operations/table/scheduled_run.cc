#include "core/operations/table/scheduled_run.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace takt::operations {
namespace {

/// A program can go on after it.
bool is_of_the_run(activity::RunFailure failure) {
  return failure == activity::RunFailure::kFault || failure == activity::RunFailure::kRefused ||
         failure == activity::RunFailure::kStopped;
}

}  // namespace

bool is_due(double rate, const activity::Context& context) {
  const double cycles = 1.0 / (rate * to_seconds(context.core.period()));
  return context.core.cycle() % std::max<std::int64_t>(1, std::llround(cycles)) == 0;
}

Progress ScheduledRun::advance(activity::Context& context, Diagnostics& diagnostics) {
  if (!run_) {
    if (cancelled_) return Progress::kDone;
    if (waits(context)) return Progress::kRunning;
    activity::ActivityPtr wanted = activity(context);
    if (!have_samples(*wanted, context.cell)) return Progress::kRunning;
    run_ = context.scheduler->schedule(std::move(wanted));
    context.scheduler->prepare(run_);  // others may move the frames of its goals in this very cycle
  }
  if (!run_->over()) return watch(context, diagnostics);
  ended(context);
  return run_->state() == activity::RunState::kFailed ? fail(diagnostics) : finish(context, diagnostics);
}

bool ScheduledRun::waits(const activity::Context& context) {
  const double cycles = wait_before(context) / to_seconds(context.core.period());
  if (begin_ < 0) begin_ = context.core.cycle() + std::llround(cycles);
  return context.core.cycle() < begin_;
}

bool ScheduledRun::have_samples(const activity::ActivityModel& model, const expression::Cell& cell) {
  return std::ranges::none_of(model.actuators(), [&cell](const std::string& name) {
    const auto arm = cell.arms.find(name);
    if (arm == cell.arms.end()) return false;
    const device::Arm& device = *arm->second.device;
    return device.set_point().q.size() == 0 && !activity::has_fault(device);  // the scheduler reports a fault
  });
}

Progress ScheduledRun::fail(Diagnostics& diagnostics) const {
  bool first = true;
  const Diagnostics inside = run_->diagnostics_inside();
  for (Diagnostic diagnostic : inside.list()) {
    diagnostic.pointer = location_of(std::move(diagnostic.pointer));
    if (std::exchange(first, false) && is_of_the_run(run_->failure()))
      diagnostic.hint = "Put \"try\" around the step where the program can go on";
    diagnostics.add(std::move(diagnostic));
  }
  return Progress::kFailed;
}

}  // namespace takt::operations
