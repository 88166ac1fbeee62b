#pragma once

#include <expected>
#include <span>

#include "core/activity/start_conditions.h"

namespace takt::activity {

/// Plans a run as soon as enough is known of its actuators: planning, prepare(), mapping, LOAD, the rule that starts
/// it. Owned by the scheduler; thread: the program's. Realtime: setup.
class RunPlanner {
 public:
  RunPlanner(rcc::ControlCore& core, const command::Cell& cell, const StartConditions::Options& options)
      : core_(core), conditions_(core, cell, options) {}

  /// Why a run cannot be done.
  struct Obstacle {
    RunFailure failure = RunFailure::kImpossible;
    Diagnostics diagnostics;
  };
  /// @param runs  in the order in which they were asked for, `run` among them
  /// @return whether it is planned; false: it has to wait
  [[nodiscard]] std::expected<bool, Obstacle> try_plan(ActivityRun& run, std::span<const RunPtr> runs);

 private:
  [[nodiscard]] Diagnostics plan(ActivityRun& run, PlanningContext& planning) const;
  [[nodiscard]] Diagnostics load(ActivityRun& run);

  rcc::ControlCore& core_;
  StartConditions conditions_;
};

}  // namespace takt::activity
