#include "core/operations/motion/motion_activity.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/activity/motion_collisions.h"
#include "core/expression/condition_state.h"
#include "core/operations/motion/activity_review.h"
#include "core/operations/motion/clear_blends.h"
#include "core/operations/motion/motion_verdict.h"

namespace takt::operations {
namespace {

using kinematics::JointVector;
using Places = std::map<std::string, JointVector, std::less<>>;

/// A cell in which the frame that a motion moves is the tool centre point of its arm.
class SeenCell {
 public:
  SeenCell(const expression::Cell& cell, const MotionTask& task) : cell_(cell) {
    if (!task.X_FM) return;
    own_ = cell;
    own_->arms.find(task.arm)->second.X_FT = *task.X_FM;
  }
  [[nodiscard]] const expression::Cell& cell() const { return own_ ? *own_ : cell_; }

 private:
  const expression::Cell& cell_;
  std::optional<expression::Cell> own_;
};

activity::PlanningContext nothing_before(const expression::Cell& cell) {
  return {.cell = cell, .period = kMillisecond, .predecessors = {}};
}

void check_blend(const MotionTask& task, Diagnostics& diagnostics) {
  const activity::BlendingCondition& blend = task.blend;
  if (blend.wanted() && task.until)
    diagnostics.error(Code::kConflict, "/blend", "the end of a guarded motion is unknown",
                      "Remove the blend or the condition");
  if (blend.time_share && task.blends())
    diagnostics.error(Code::kConflict, "/blend", "a blend by time and by distance", "Give one of them");
  if (blend.time_share && !(*blend.time_share >= 0.5 && *blend.time_share < 1.0))
    diagnostics.error(Code::kOutOfRange, "/blend", fmt::format("a blend at a share of {:g}", *blend.time_share),
                      "Give a share of the time, at least 0.5 and below 1");
}

/// Diagnostics of one motion of several have the pointers of a step: those of a later one are named in the text.
MotionPlaces places_in(const std::vector<MotionTask>& tasks) {
  return [&tasks](int motion) -> MotionPlace {
    if (motion < 0) return {.has_keys = false, .prefix = "'abort_if' of the motion that it went on with: "};
    if (motion == 0) return {};
    return {.has_keys = false,
            .prefix = fmt::format("in '{}', which is blended into: ", tasks[static_cast<std::size_t>(motion)].name)};
  };
}

/// The arms hold the common motion centre as they did when they took hold of it.
Diagnostics check_hold(const Eigen::Isometry3d& X_HF_now, const Eigen::Isometry3d& X_HF) {
  const double apart = (X_HF_now.translation() - X_HF.translation()).norm();
  const double turned = Eigen::AngleAxisd(X_HF_now.linear().transpose() * X_HF.linear()).angle();
  Diagnostics diagnostics;
  constexpr double kApart = 1e-6, kTurned = 1e-6;  // m, rad
  if (apart > kApart || turned > kTurned)
    diagnostics.error(
        Code::kUnknownPosition, "/grasp",
        fmt::format("the arms disagree about the motion centre by {:.3g} mm and {:.3g} rad", 1e3 * apart, turned),
        "Create TwoArms again where they are, or move each arm back to where it took hold");
  return diagnostics;
}

}  // namespace

MotionActivity::MotionActivity(std::string name, std::vector<MotionTask> tasks, expression::Biases biases,
                               activity::ConcurrentMotions meanwhile)
    : activity::ActivityModel(std::move(name)),
      tasks_(std::move(tasks)),
      biases_(std::move(biases)),
      meanwhile_(std::move(meanwhile)) {}

std::vector<std::string> MotionActivity::actuators() const {
  return of_two_arms() ? std::vector{last().arm, last().follower} : std::vector{last().arm};
}

bool MotionActivity::avoids_others() const {
  return std::ranges::any_of(tasks_, [](const MotionTask& task) { return task.kind == PathKind::kMove; });
}

std::shared_ptr<const activity::ActivityModel> MotionActivity::blended_into(const activity::ActivityModel& next) const {
  const auto* other = dynamic_cast<const MotionActivity*>(&next);
  if (other == nullptr || !last().blend.wanted() || last().until) return nullptr;
  const MotionTask& after = other->tasks_.front();
  if (moved_by(after) != moved_by(last()) || after.compliance != last().compliance) return nullptr;
  const auto same_frame = [](const auto& a, const auto& b) {
    return a.has_value() == b.has_value() && (!a || a->matrix() == b->matrix());
  };
  if (!same_frame(after.X_FM, last().X_FM) || !same_frame(after.X_HF, last().X_HF)) return nullptr;
  std::vector<MotionTask> tasks = tasks_;
  tasks.insert(tasks.end(), other->tasks_.begin(), other->tasks_.end());
  if (check_offsets(tasks).has_errors()) return nullptr;
  constexpr std::size_t kFew = 4;
  std::string name = fmt::format("{} {} motions", moved_by(last()), tasks.size());
  const std::string mover = last().name.substr(0, last().name.find(' '));
  if (tasks.size() <= kFew && other->name().starts_with(mover))
    name = this->name() + other->name().substr(mover.size());
  return std::make_shared<const MotionActivity>(std::move(name), std::move(tasks), biases_, meanwhile_);
}

Diagnostics MotionActivity::check(const expression::Cell& cell) const {
  Diagnostics diagnostics;
  for (const MotionTask& task : tasks_) check_blend(task, diagnostics);
  diagnostics.append(of_motions(check_offsets(tasks_), tasks_, /*named=*/true));
  if (last().compliance && !diagnostics.has_errors())
    diagnostics.append(check_compliance(*last().compliance, cell, actuators()));
  return diagnostics;
}

Result<activity::PlannedActivity> MotionActivity::prepare(const activity::PlanningContext& planning) const {
  for (const std::string& arm : actuators()) {
    if (planning.predecessors.find(arm)->second.at_end.rests()) continue;
    return failure(Code::kUnknownPosition, "",
                   fmt::format("'{}': the end position of '{}' is unknown before the run", name(), arm),
                   "Ask for the motion after the end of what runs");
  }
  if (Diagnostics wrong = check(planning.cell); wrong.has_errors()) return std::unexpected(std::move(wrong));
  const SeenCell seen(planning.cell, last());
  auto prepared = of_two_arms() ? prepare_two(planning, seen.cell()) : prepare_one(planning, seen.cell());
  if (prepared)
    prepared->verdict = [tasks = tasks_](const activity::RunView& run) {
      if (!run.may_have_failed()) return Diagnostics();
      return motion_verdict(tasks, activity::guarded_end(run, static_cast<int>(tasks.size())), places_in(tasks));
    };
  return prepared;
}

Result<activity::PlannedActivity> MotionActivity::prepare_one(const activity::PlanningContext& planning,
                                                              const expression::Cell& seen) const {
  const JointVector& q = *planning.predecessors.find(last().arm)->second.at_end.q;
  ActivityReview review(tasks_, planning, seen);
  auto plan = plan_motions(tasks_, seen, q, surroundings(planning, review));
  while (review.plan_again(plan)) plan = plan_motions(tasks_, seen, q, surroundings(planning, review));
  if (!plan) return std::unexpected(std::move(plan.error()));
  if (Diagnostics wrong = review.collisions(*plan); wrong.has_errors()) return std::unexpected(std::move(wrong));
  // What is laid over the first motion begins at rest.
  const Surroundings around = surroundings(planning, review);
  auto from_blend = tasks_.front().has_overlay() ? std::nullopt : blended_plan(planning, seen, around, *plan);
  return with_plans(planning, seen, std::move(*plan), std::move(from_blend));
}

/// A corner must not be cut into something: then the arm comes to rest at it.
std::optional<motion::SequencePlan> MotionActivity::blended_plan(const activity::PlanningContext& planning,
                                                                 const expression::Cell& seen,
                                                                 const Surroundings& around,
                                                                 const motion::SequencePlan& from_rest) const {
  const expression::MountedArm& arm = seen.arms.find(last().arm)->second;
  const auto from = activity::departure_of(planning.predecessors.find(last().arm)->second, arm.X_FT);
  if (!from) return std::nullopt;
  auto plan = plan_motions_from(*from, tasks_, seen, around);
  if (!plan || !is_clear_blend(tasks_, seen, expression::planning_model(arm), around, from_rest, *plan))
    return std::nullopt;
  return std::move(*plan);
}

Result<activity::PlannedActivity> MotionActivity::with_plans(const activity::PlanningContext& planning,
                                                             const expression::Cell& seen,
                                                             motion::SequencePlan from_rest,
                                                             std::optional<motion::SequencePlan> from_blend) const {
  const motion::ArmModel model = expression::planning_model(seen.arms.find(last().arm)->second);
  activity::ArmPlans plans{.name = name(),
                           .arm = last().arm,
                           .model = model,
                           .from_rest = std::move(from_rest),
                           .from_blend = std::move(from_blend),
                           .abort_if = abort_states(planning.cell),
                           .weaves = weaves_of(tasks_),
                           .offset = offset(planning.cell)};
  auto prepared = activity::prepare_dual_entry(planning, std::move(plans), options(planning.cell));
  if (!prepared) return std::unexpected(of_motions(prepared.error(), tasks_));
  return prepared;
}

/// They move the common motion centre, which is the frame that the leader moves.
Result<activity::PlannedActivity> MotionActivity::prepare_two(const activity::PlanningContext& planning,
                                                              const expression::Cell& seen) const {
  const JointVector& q_leader = *planning.predecessors.find(last().arm)->second.at_end.q;
  const JointVector& q_follower = *planning.predecessors.find(last().follower)->second.at_end.q;
  auto held = grasp(seen, q_leader, q_follower);
  if (!held) return std::unexpected(std::move(held.error()));
  // They hold the part as before, to the last bit.
  const auto* leaving = activity::leaving_pair(planning, held->leader, held->follower);
  if (leaving != nullptr && !last().X_HF) held->X_HF = leaving->motion.partner_X_FM;
  auto from_rest = plan_pair_motions(tasks_, seen, activity::pair_of(seen, *held), q_leader, q_follower);
  if (!from_rest) return std::unexpected(std::move(from_rest.error()));
  auto from_blend = activity::plan_pair_on(planning, *held, leg_makers(tasks_, seen));
  const ActivityReview review(tasks_, planning, seen);
  if (Diagnostics wrong = review.collisions(*held, *from_rest); wrong.has_errors())
    return std::unexpected(std::move(wrong));
  return with_plans(planning, *held, std::move(*from_rest), std::move(from_blend));
}

activity::PlannedActivity MotionActivity::with_plans(const activity::PlanningContext& planning,
                                                     const activity::Grasp& grasp, motion::PairPlan from_rest,
                                                     std::optional<motion::PairPlan> from_blend) const {
  activity::PairPlans plans{.name = name(),
                            .grasp = grasp,
                            .from_rest = std::move(from_rest),
                            .from_blend = std::move(from_blend),
                            .abort_if = abort_states(planning.cell)};
  return activity::prepare_dual_entry(planning, std::move(plans), options(planning.cell));
}

Result<activity::Grasp> MotionActivity::grasp(const expression::Cell& seen, const JointVector& q_leader,
                                              const JointVector& q_follower) const {
  auto held = activity::grasp_at(seen, last().arm, last().follower, q_leader, q_follower);
  if (!held || !last().X_HF) return held;
  if (Diagnostics apart = check_hold(held->X_HF, *last().X_HF); apart.has_errors())
    return std::unexpected(std::move(apart));
  held->X_HF = *last().X_HF;
  return held;
}

Result<MotionActivity::StandalonePlan> MotionActivity::alone(const expression::Cell& cell, const Places& q,
                                                             const Surroundings& surroundings) const {
  if (Diagnostics wrong = of_motions(check_offsets(tasks_), tasks_, /*named=*/true); wrong.has_errors())
    return std::unexpected(std::move(wrong));
  const JointVector& q_arm = q.find(last().arm)->second;
  if (of_two_arms()) {
    const JointVector& q_follower = q.find(last().follower)->second;
    const auto held = grasp(cell, q_arm, q_follower);
    if (!held) return std::unexpected(held.error());
    auto plan = plan_pair_motions(tasks_, cell, activity::pair_of(cell, *held), q_arm, q_follower);
    if (!plan) return std::unexpected(std::move(plan.error()));
    StandalonePlan alone{.prepared = {},
                         .notes = plan->notes,
                         .q_goal = {{last().arm, plan->leader.q_goal}, {last().follower, plan->follower.q_goal}},
                         .duration = plan->leader.duration()};
    alone.prepared = with_plans(nothing_before(cell), *held, std::move(*plan), std::nullopt);
    return alone;
  }
  auto plan = plan_motions(tasks_, cell, q_arm, surroundings);
  if (!plan) return std::unexpected(std::move(plan.error()));
  StandalonePlan alone{.prepared = {},
                       .notes = plan->notes,
                       .q_goal = {{last().arm, plan->motion.q_goal}},
                       .duration = plan->motion.duration()};
  auto prepared = with_plans(nothing_before(cell), cell, std::move(*plan), std::nullopt);
  if (!prepared) return std::unexpected(std::move(prepared.error()));
  alone.prepared = std::move(*prepared);
  return alone;
}

Surroundings MotionActivity::surroundings(const activity::PlanningContext& planning,
                                          const ActivityReview& review) const {
  return {.situation = [&planning] { return activity::situation_before(planning); },
          .meanwhile = planning.beside.empty() ? meanwhile_ : review.meanwhile()};
}

activity::MotionOptions MotionActivity::options(const expression::Cell& cell) const {
  activity::MotionOptions options{.blend = last().blend, .must_touch = last().must_touch};
  if (last().until) options.until = expression::state_of(*last().until, cell, biases_);
  const int joint_count = cell.arms.find(last().arm)->second.device->description().chain->joint_count();
  if (last().compliance) options.compliance = compliance_of(*last().compliance, joint_count);
  return options;
}

std::vector<std::optional<expression::State>> MotionActivity::abort_states(const expression::Cell& cell) const {
  std::vector<std::optional<expression::State>> states;
  for (const MotionTask& task : tasks_)
    states.push_back(task.abort_if ? std::optional(expression::state_of(*task.abort_if, cell, biases_)) : std::nullopt);
  return states;
}

std::optional<activity::OffsetPlan> MotionActivity::offset(const expression::Cell& cell) const {
  const auto first = first_offset(tasks_);
  if (!first) return std::nullopt;
  const ForceOffsetParameters& force = *tasks_[*first].force_offset;
  return activity::OffsetPlan{.pressing = force.pressing(last().arm, cell, biases_),
                              .parameters = force.control_parameters(cell),
                              .first = *first};
}

}  // namespace takt::operations
