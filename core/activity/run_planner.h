#pragma once

#include <expected>
#include <span>

#include "core/activity/planning_thread.h"
#include "core/activity/start_conditions.h"

namespace takt::activity {

/// Plans a run as soon as enough is known of its actuators: planning, mapping, LOAD, the rule that starts it. With a
/// PlanningThread the long part is done there, and the run waits for it. Owned by the scheduler; thread: the program's.
/// Realtime: setup.
class RunPlanner {
 public:
  /// @param thread  null: the caller's thread plans
  RunPlanner(rcc::ControlCore& core, const expression::Cell& cell, const StartConditions::Options& options,
             PlanningThread* thread)
      : core_(core), conditions_(core, cell, options), thread_(thread) {}

  /// Why a run cannot be done.
  struct Obstacle {
    RunFailure failure = RunFailure::kImpossible;
    Diagnostics diagnostics;
  };
  /// @param runs  in the order in which they were asked for, `run` among them
  /// @return whether it is planned; false: it has to wait
  [[nodiscard]] std::expected<bool, Obstacle> try_plan(ActivityRun& run, std::span<const RunPtr> runs);

 private:
  /// @return a job that is done; null: not yet
  [[nodiscard]] std::expected<std::shared_ptr<PlanningJob>, Obstacle> job_of(ActivityRun& run, const RunsBefore& before,
                                                                             std::span<const RunPtr> runs);

  rcc::ControlCore& core_;
  StartConditions conditions_;
  PlanningThread* thread_;
};

}  // namespace takt::activity
