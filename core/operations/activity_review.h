#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/operations/motion.h"
#include "core/operations/move_review.h"

/// A `move` of a program that nobody rehearses, beside what its other activities do meanwhile (docs/planning.md,
/// "Beside machines that move"). Realtime: setup.
namespace takt::activity {

/// Has a `move` planned again until it keeps clear of the planned motions that run, or are about to begin, when it is
/// prepared (PlanningContext::beside). Where there are none it does nothing.
class ActivityReview {
 public:
  /// Both must outlive it.
  ActivityReview(const std::vector<MotionTask>& requests, const PlanningContext& planning);

  /// What it has to be planned with.
  [[nodiscard]] const Meanwhile& meanwhile() const { return meanwhile_; }
  /// @return true: it is to be planned again
  [[nodiscard]] bool plan_again(const Result<motion::SequencePlan>& plan);
  /// What it would meet on the clock all the same.
  [[nodiscard]] Diagnostics collisions(const motion::SequencePlan& plan) const;

 private:
  void add_beside();
  [[nodiscard]] PlayedSteps steps_with(const motion::SequencePlan* plan) const;

  const std::vector<MotionTask>& requests_;
  const PlanningContext& planning_;
  Meanwhile meanwhile_ = {};
  std::optional<MoveReview> review_ = {};  ///< null: nothing moves beside it
  std::optional<collision::Situation> begin_ = {};
  PlayedSteps beside_ = {};
  BranchParents branches_ = {-1};
};

}  // namespace takt::activity
