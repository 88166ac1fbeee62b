#include "core/operations/scheduled_run.h"

#include <algorithm>
#include <utility>

namespace takt::activity {

Progress ScheduledRun::advance(Context& context, Findings& findings) {
  if (!run_) {
    if (cancelled_) return Progress::kDone;
    ActivityPtr wanted = activity(context);
    if (!have_samples(*wanted, context.cell)) return Progress::kRunning;
    run_ = context.scheduler->schedule(std::move(wanted));
    context.scheduler->prepare(run_);  // others may move the frames of its goals in this very cycle
  }
  if (!run_->over()) return Progress::kRunning;
  return run_->state() == RunState::kFailed ? fail(findings) : finish(context, findings);
}

bool ScheduledRun::have_samples(const ActivityModel& model, const command::Cell& cell) {
  return std::ranges::none_of(model.actuators(), [&cell](const std::string& name) {
    const auto arm = cell.arms.find(name);
    return arm != cell.arms.end() && arm->second.device->set_point().q.size() == 0;
  });
}

Progress ScheduledRun::fail(Findings& findings) const {
  // An activity names itself first; here the place is the step.
  const std::string own = pointer_segment(run_->name());
  for (Finding finding : run_->findings().list()) {
    if (finding.pointer.starts_with(own)) finding.pointer.erase(0, own.size());
    finding.pointer = place_of(std::move(finding.pointer));
    if (finding.hint == Scheduler::kAgain) finding.hint = "\"try\" around the step";
    findings.add(std::move(finding));
  }
  return Progress::kFailed;
}

}  // namespace takt::activity
