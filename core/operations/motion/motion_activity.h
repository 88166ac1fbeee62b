#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/activity/dual_entry_motion.h"
#include "core/activity/pair_motion.h"
#include "core/operations/motion/motion_plan.h"

namespace takt::operations {

class ActivityReview;

/// Motions of one arm, or of two as one, as steps of a file or programs in C++ ask for them, each blended into the next
/// one: planned from rest and from what may be left before, kept clear of what moves meanwhile, and judged at its end
/// (motion_verdict()). Diagnostics have pointers below the first motion.
class MotionActivity final : public activity::ActivityModel {
 public:
  /// @param tasks      at least one, all of the same arm, or of the same two
  /// @param biases     of the sensors in their conditions
  /// @param meanwhile  what others do while a `move` among them is carried out
  MotionActivity(std::string name, std::vector<MotionTask> tasks, expression::Biases biases,
                 activity::ConcurrentMotions meanwhile = {});

  [[nodiscard]] std::vector<std::string> actuators() const override;
  [[nodiscard]] bool avoids_others() const override;
  [[nodiscard]] Result<activity::PlannedActivity> prepare(const activity::PlanningContext& planning) const override;
  [[nodiscard]] std::shared_ptr<const activity::ActivityModel> blended_into(
      const activity::ActivityModel& next) const override;

  /// What it is when nothing precedes it.
  struct StandalonePlan {
    activity::PlannedActivity prepared;
    Diagnostics notes;                                                   ///< of the planner, with pointers of the file
    std::map<std::string, kinematics::JointVector, std::less<>> q_goal;  ///< of each arm, rad or m
    double duration = 0.0;                                               ///< s
  };
  /// @param q  where each of its arms is, rad or m
  /// @param surroundings  what a `move` avoids
  [[nodiscard]] Result<StandalonePlan> alone(const expression::Cell& cell,
                                             const std::map<std::string, kinematics::JointVector, std::less<>>& q,
                                             const Surroundings& surroundings) const;

 private:
  [[nodiscard]] const MotionTask& last() const { return tasks_.back(); }
  [[nodiscard]] bool of_two_arms() const { return !last().follower.empty(); }
  [[nodiscard]] Diagnostics check(const expression::Cell& cell) const;
  /// @param seen  the cell with the frame that moves as tool centre point
  [[nodiscard]] Result<activity::PlannedActivity> prepare_one(const activity::PlanningContext& planning,
                                                              const expression::Cell& seen) const;
  [[nodiscard]] Result<activity::PlannedActivity> prepare_two(const activity::PlanningContext& planning,
                                                              const expression::Cell& seen) const;
  [[nodiscard]] Result<activity::PlannedActivity> with_plans(const activity::PlanningContext& planning,
                                                             const expression::Cell& seen,
                                                             motion::SequencePlan from_rest,
                                                             std::optional<motion::SequencePlan> from_blend) const;
  [[nodiscard]] activity::PlannedActivity with_plans(const activity::PlanningContext& planning,
                                                     const activity::Grasp& grasp, motion::PairPlan from_rest,
                                                     std::optional<motion::PairPlan> from_blend) const;
  [[nodiscard]] std::optional<motion::SequencePlan> blended_plan(const activity::PlanningContext& planning,
                                                                 const expression::Cell& seen,
                                                                 const Surroundings& around,
                                                                 const motion::SequencePlan& from_rest) const;
  [[nodiscard]] Result<activity::Grasp> grasp(const expression::Cell& seen, const kinematics::JointVector& q_leader,
                                              const kinematics::JointVector& q_follower) const;
  [[nodiscard]] Surroundings surroundings(const activity::PlanningContext& planning,
                                          const ActivityReview& review) const;
  [[nodiscard]] activity::MotionOptions options(const expression::Cell& cell) const;
  [[nodiscard]] std::vector<std::optional<expression::State>> abort_states(const expression::Cell& cell) const;
  [[nodiscard]] std::optional<activity::OffsetPlan> offset(const expression::Cell& cell) const;

  std::vector<MotionTask> tasks_;
  expression::Biases biases_;
  activity::ConcurrentMotions meanwhile_;
};

}  // namespace takt::operations
