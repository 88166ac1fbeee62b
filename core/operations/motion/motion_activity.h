#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/activity/dual_entry_motion.h"
#include "core/activity/pair_motion.h"
#include "core/operations/motion/motion_plan.h"

namespace takt::activity {

class ActivityReview;

/// Motions of one arm, or of two as one, as steps of a file or programs in C++ ask for them, each blended into the next
/// one: planned from rest and from what may be left before, kept clear of what moves meanwhile, and judged at its end
/// (motion_verdict()). Diagnostics have pointers below the first motion.
class MotionActivity final : public ActivityModel {
 public:
  /// @param tasks      at least one, all of the same arm, or of the same two
  /// @param biases     of the sensors in their conditions
  /// @param meanwhile  what others do while a `move` among them is carried out
  MotionActivity(std::string name, std::vector<MotionTask> tasks, command::Biases biases,
                 ConcurrentMotions meanwhile = {});

  [[nodiscard]] std::vector<std::string> actuators() const override;
  [[nodiscard]] bool avoids_others() const override;
  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override;
  [[nodiscard]] std::shared_ptr<const ActivityModel> blended_into(const ActivityModel& next) const override;

  /// What it is when nothing precedes it.
  struct StandalonePlan {
    PlannedActivity prepared;
    Diagnostics notes;                                                   ///< of the planner, with pointers of the file
    std::map<std::string, kinematics::JointVector, std::less<>> q_goal;  ///< of each arm, rad or m
    double duration = 0.0;                                               ///< s
  };
  /// @param q  where each of its arms is, rad or m
  /// @param surroundings  what a `move` avoids
  [[nodiscard]] Result<StandalonePlan> alone(const command::Cell& cell,
                                             const std::map<std::string, kinematics::JointVector, std::less<>>& q,
                                             const Surroundings& surroundings) const;

 private:
  [[nodiscard]] const MotionTask& last() const { return tasks_.back(); }
  [[nodiscard]] bool of_two_arms() const { return !last().follower.empty(); }
  [[nodiscard]] Diagnostics check(const command::Cell& cell) const;
  /// @param seen  the cell with the frame that moves as tool centre point
  [[nodiscard]] Result<PlannedActivity> prepare_one(const PlanningContext& planning, const command::Cell& seen) const;
  [[nodiscard]] Result<PlannedActivity> prepare_two(const PlanningContext& planning, const command::Cell& seen) const;
  [[nodiscard]] Result<PlannedActivity> with_plans(const PlanningContext& planning, const command::Cell& seen,
                                                   motion::SequencePlan from_rest,
                                                   std::optional<motion::SequencePlan> from_blend) const;
  [[nodiscard]] PlannedActivity with_plans(const PlanningContext& planning, const Grasp& grasp,
                                           motion::PairPlan from_rest,
                                           std::optional<motion::PairPlan> from_blend) const;
  [[nodiscard]] std::optional<motion::SequencePlan> blended_plan(const PlanningContext& planning,
                                                                 const command::Cell& seen, const Surroundings& around,
                                                                 const motion::SequencePlan& from_rest) const;
  [[nodiscard]] Result<Grasp> grasp(const command::Cell& seen, const kinematics::JointVector& q_leader,
                                    const kinematics::JointVector& q_follower) const;
  [[nodiscard]] Surroundings surroundings(const PlanningContext& planning, const ActivityReview& review) const;
  [[nodiscard]] MotionOptions options(const command::Cell& cell) const;
  [[nodiscard]] std::vector<std::optional<command::State>> abort_states(const command::Cell& cell) const;
  [[nodiscard]] std::optional<OffsetPlan> offset(const command::Cell& cell) const;

  std::vector<MotionTask> tasks_;
  command::Biases biases_;
  ConcurrentMotions meanwhile_;
};

}  // namespace takt::activity
