#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/activity/motion_collisions.h"
#include "core/activity/pair_motion.h"
#include "core/operations/motion/motion.h"
#include "core/operations/review/move_review.h"

/// A motion of a program that nobody rehearses, beside what its other activities do meanwhile (docs/planning.md,
/// "Beside machines that move"). Realtime: setup.
namespace takt::operations {

/// Looks at the planned motions that run, or are about to begin, when a motion is prepared (PlanningContext::beside):
/// has a `move` planned again until it keeps clear of them, and says what any other motion would meet. Where there are
/// none it does nothing.
class ActivityReview {
 public:
  /// All must outlive it. @param seen  the cell with the frame that moves as tool centre point
  ActivityReview(const std::vector<MotionTask>& requests, const activity::PlanningContext& planning,
                 const expression::Cell& seen);

  /// What it has to be planned with.
  [[nodiscard]] const activity::ConcurrentMotions& meanwhile() const { return meanwhile_; }
  /// @return true: it is to be planned again
  [[nodiscard]] bool plan_again(const Result<motion::SequencePlan>& plan);
  /// What it would meet on the clock all the same.
  [[nodiscard]] Diagnostics collisions(const motion::SequencePlan& plan) const;
  [[nodiscard]] Diagnostics collisions(const activity::Grasp& grasp, const motion::PairPlan& plan) const;

 private:
  void add_beside();
  [[nodiscard]] std::vector<activity::ArmTrack> tracks_along(const motion::SequencePlan& plan) const;
  [[nodiscard]] PlayedSteps steps_with(std::vector<activity::ArmTrack> tracks) const;
  [[nodiscard]] Diagnostics met_by(std::vector<activity::ArmTrack> tracks) const;

  const std::vector<MotionTask>& requests_;
  const activity::PlanningContext& planning_;
  const expression::Cell& seen_;
  activity::ConcurrentMotions meanwhile_ = {};
  std::optional<MoveReview> review_ = {};           ///< null: no `move`, or nothing moves beside it
  std::optional<collision::CellState> begin_ = {};  ///< null: nothing moves beside it
  PlayedSteps beside_ = {};
  BranchParents branches_ = {-1};
};

}  // namespace takt::operations
