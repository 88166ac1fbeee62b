#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "core/activity/activity_model.h"
#include "core/command/mapping.h"
#include "core/rcc/control_core.h"

namespace takt::activity {

/// The long part of making an activity ready: planning, mapping to a net, LOAD. It may be carried out on another thread
/// than the program's: then it works on a copy of the cell, and what it found is read once it is done().
class PlanningJob {
 public:
  enum class Cell { kShared, kCopied };  ///< whose thread carries it out: the program's, or another one

  PlanningJob(rcc::ControlCore& core, ActivityPtr model, PlanningContext planning, Cell cell);
  /// Unloads the net if no run has taken it.
  ~PlanningJob();
  PlanningJob(const PlanningJob&) = delete;
  PlanningJob& operator=(const PlanningJob&) = delete;

  /// Once, on any one thread. Whatever it throws becomes a diagnostic. Realtime: setup.
  void carry_out() noexcept;
  /// What follows may be read. Any thread.
  [[nodiscard]] bool done() const { return done_.load(std::memory_order_acquire); }

  /// With what it was planned: of the predecessors those that it can take over in motion still have `leaving`.
  [[nodiscard]] const PlanningContext& planning() const { return planning_; }
  [[nodiscard]] double planning_time() const { return planning_time_; }  ///< CPU time, s
  [[nodiscard]] double total_time() const { return total_time_; }        ///< CPU time with mapping and LOAD, s

  /// Why it cannot be done; errors: there is no result.
  [[nodiscard]] Diagnostics take_diagnostics() { return std::move(diagnostics_); }
  [[nodiscard]] PlannedActivity take_activity() { return std::move(planned_); }
  /// 0: it needs none. It belongs to the caller from now on.
  [[nodiscard]] rcc::NetId take_net() { return std::exchange(net_, 0); }
  [[nodiscard]] command::MappedCommand take_mapped() { return std::move(mapped_); }

 private:
  void carry_out_or_throw();
  [[nodiscard]] Diagnostics plan();
  [[nodiscard]] Diagnostics load();

  rcc::ControlCore& core_;
  ActivityPtr model_;
  std::unique_ptr<const expression::Cell> cell_;  ///< the copy; null: none was made
  PlanningContext planning_;
  PlannedActivity planned_;
  command::MappedCommand mapped_;
  rcc::NetId net_ = 0;
  Diagnostics diagnostics_;
  double planning_time_ = 0.0, total_time_ = 0.0;
  std::atomic<bool> done_ = false;
};

}  // namespace takt::activity
