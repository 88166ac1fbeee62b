#include "core/activity/run_planner.h"

#include <utility>

#include <fmt/format.h>

namespace takt::activity {

std::expected<bool, RunPlanner::Obstacle> RunPlanner::try_plan(ActivityRun& run, std::span<const RunPtr> runs) {
  const RunsBefore before = StartConditions::runs_before(run, runs);
  if (before.wait || (run.after_all_ && !before.running.empty())) return false;
  auto job = job_of(run, before, runs);
  if (!job) return std::unexpected(std::move(job.error()));
  if (*job == nullptr) return false;
  PlanningJob& done = **job;
  Obstacle obstacle{.failure = RunFailure::kImpossible, .diagnostics = done.take_diagnostics()};
  run.preparation_ = {.planning = done.planning_time(), .total = done.total_time()};
  if (!obstacle.diagnostics.has_errors()) {
    run.planned_ = done.take_activity();
    run.net_ = done.take_net();
    if (run.net_ == 0) return true;
    obstacle.diagnostics = run.attach(done.take_mapped());
  }
  if (obstacle.diagnostics.has_errors()) return std::unexpected(std::move(obstacle));
  run.rule_ = StartConditions::rule_for(run, before, done.planning());
  if (run.rule_) return true;
  run.forget_net();
  run.after_all_ = true;
  return false;
}

std::expected<std::shared_ptr<PlanningJob>, RunPlanner::Obstacle> RunPlanner::job_of(ActivityRun& run,
                                                                                     const RunsBefore& before,
                                                                                     std::span<const RunPtr> runs) {
  const std::string fault = before.running.empty() ? conditions_.fault_of(run) : std::string();
  if (!fault.empty()) {
    Obstacle obstacle{.failure = RunFailure::kFault, .diagnostics = {}};
    obstacle.diagnostics.error(Code::kDeviceFault, "", fmt::format("'{}' was given up: {}", run.name(), fault),
                               "Remove the cause, acknowledge the fault, and ask for it again");
    return std::unexpected(std::move(obstacle));
  }
  if (run.job_ == nullptr) {
    auto planning = conditions_.planning_context(run, before);
    if (!planning) return nullptr;
    planning->beside = conditions_.motions_beside(run, runs);
    const auto cell = thread_ != nullptr ? PlanningJob::Cell::kCopied : PlanningJob::Cell::kShared;
    run.job_ = std::make_shared<PlanningJob>(core_, run.model_, std::move(*planning), cell);
    if (thread_ == nullptr) {
      run.job_->carry_out();
    } else {
      thread_->submit([job = run.job_] { job->carry_out(); });
    }
  }
  if (!run.job_->done()) return nullptr;
  // What was planned may refer to the job's copy of the cell.
  run.planned_with_ = std::exchange(run.job_, nullptr);
  return run.planned_with_;
}

}  // namespace takt::activity
