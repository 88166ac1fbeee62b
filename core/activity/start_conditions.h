#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/activity/activity_run.h"

namespace takt::activity {

/// Who has the actuators of a run before it.
struct RunsBefore {
  std::vector<ActivityRun*> running;
  bool wait = false;  ///< some of them have not begun yet, or their end cannot be foreseen
};

/// What has to be known before a run can be planned, and when its net may start: from who has its actuators, where they
/// will be, and whether they can be left in motion (docs/activity-layer.md). Owned by the scheduler; thread: the
/// program's. Realtime: setup.
class StartConditions {
 public:
  struct Options {
    std::int64_t latency_cycles = 2;  ///< from a program's request to its effect (row D2)
    std::int64_t margin_cycles = 3;   ///< beyond that, until a motion is taken over
    std::int64_t lead_cycles = 4;     ///< in which it may be taken over
    bool checks_collisions = false;   ///< PlanningContext::checks_collisions
  };
  StartConditions(rcc::ControlCore& core, const expression::Cell& cell, const Options& options)
      : core_(core), cell_(cell), options_(options) {}

  /// @param runs  in the order in which they were asked for, `run` among them
  [[nodiscard]] static RunsBefore runs_before(const ActivityRun& run,
                                              std::span<const std::shared_ptr<ActivityRun>> runs);
  /// Why an arm of the run cannot be driven before its fault is acknowledged; empty: none has one.
  [[nodiscard]] std::string fault_of(const ActivityRun& run) const;
  /// What the run may be planned with. Nothing: not known yet.
  [[nodiscard]] std::optional<PlanningContext> planning_context(const ActivityRun& run, const RunsBefore& before) const;
  /// What other runs do while it does, as far as that is planned (PlanningContext::beside).
  [[nodiscard]] std::vector<ConcurrentMotion> motions_beside(const ActivityRun& run,
                                                             std::span<const std::shared_ptr<ActivityRun>> runs) const;
  /// The rule that starts the net of a run that is planned. Nothing: a rule has no room for so many predecessors.
  [[nodiscard]] static std::optional<rcc::Rule> rule_for(const ActivityRun& run, const RunsBefore& before,
                                                         const PlanningContext& planning);

 private:
  /// When a planned motion of a run begins, s from now; nothing: not known.
  [[nodiscard]] std::optional<double> begin_of(const ActivityRun& run, const expression::SubjectPtr& command,
                                               bool alone) const;
  [[nodiscard]] std::optional<Predecessor> predecessor(const std::string& actuator, const RunsBefore& before,
                                                       bool& wait) const;
  [[nodiscard]] std::optional<Predecessor> at_rest(const device::Arm& arm) const;
  [[nodiscard]] std::optional<Predecessor::BlendOut> leaving(const ActivityRun& run, const EndState& end_state) const;

  rcc::ControlCore& core_;
  const expression::Cell& cell_;
  Options options_;
};

/// It brakes, or goes into another control mode.
[[nodiscard]] bool is_busy(const device::Arm& arm);
/// It cannot be driven, and waiting alone will not help: it has lost its readiness, or never had it because of a fault.
[[nodiscard]] bool has_fault(const device::Arm& arm);

}  // namespace takt::activity
