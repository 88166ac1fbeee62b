#pragma once

#include <cstdint>
#include <string>

#include "core/activity/scheduler.h"
#include "core/operations/table/step.h"

namespace takt::operations {

/// Values that are shown so many times a second are due after this cycle: in cycles whose number is a multiple of the
/// period, so that two of one rate show the same cycles. @param rate  Hz, above 0
[[nodiscard]] bool is_due(double rate, const activity::Context& context);

/// The execution of a step that is one activity: asked for when the step begins, followed to its end. Realtime: setup.
class ScheduledRun : public StepRun {
 public:
  ScheduledRun() = default;
  ~ScheduledRun() override {
    if (run_ && !run_->over()) run_->cancel();  // its program has given it up
  }
  ScheduledRun(const ScheduledRun&) = delete;
  ScheduledRun& operator=(const ScheduledRun&) = delete;

  Progress advance(activity::Context& context, Diagnostics& diagnostics) final;
  void cancel(activity::Context&) final {
    cancelled_ = true;
    if (run_) run_->cancel();
  }

 protected:
  /// What is to be done. Asked for again as long as its arms have given no sample.
  [[nodiscard]] virtual activity::ActivityPtr activity(activity::Context& context) = 0;
  /// How long it waits before that, s.
  [[nodiscard]] virtual double wait_before(const activity::Context&) const { return 0.0; }
  /// After each cycle in which it was on its way. kFailed: it is not waited for any longer.
  virtual Progress watch(activity::Context&, Diagnostics&) { return Progress::kRunning; }
  /// It is over, whether it came to its end or failed.
  virtual void ended(activity::Context&) {}
  /// It ended in order, by itself or because it was cancelled.
  virtual Progress finish(activity::Context&, Diagnostics&) { return Progress::kDone; }
  /// Where below the step something is that was found at this location below the activity.
  [[nodiscard]] virtual std::string location_of(std::string location) const { return location; }

  [[nodiscard]] const activity::RunPtr& run() const { return run_; }
  [[nodiscard]] bool cancelled() const { return cancelled_; }

 private:
  /// The first step of a program may come before the first sample.
  static bool have_samples(const activity::ActivityModel& model, const expression::Cell& cell);
  Progress fail(Diagnostics& diagnostics) const;

  [[nodiscard]] bool waits(const activity::Context& context);

  activity::RunPtr run_;
  std::int64_t begin_ = -1;  ///< cycle; before it is asked for
  bool cancelled_ = false;
};

}  // namespace takt::operations
