#include "core/operations/requested_motion.h"

#include <utility>

#include <fmt/format.h>

#include "core/activity/dual_entry_motion.h"
#include "core/activity/motion_collisions.h"
#include "core/activity/pair_motion.h"
#include "core/expression/condition_state.h"
#include "core/operations/activity_review.h"
#include "core/operations/clear_blends.h"

namespace takt::activity {
namespace {

using kinematics::JointVector;
using Places = std::map<std::string, JointVector, std::less<>>;

/// What is the same for one arm and for two.
class Requested : public RequestedMotion {
 public:
  Requested(const std::vector<MotionTask>& requests, command::Biases biases, Meanwhile meanwhile)
      : RequestedMotion(requests.front().name),
        requests_(requests),
        biases_(std::move(biases)),
        meanwhile_(std::move(meanwhile)) {}

 protected:
  [[nodiscard]] const std::vector<MotionTask>& requests() const { return requests_; }
  [[nodiscard]] const MotionTask& last() const { return requests_.back(); }
  [[nodiscard]] const command::Biases& biases() const { return biases_; }

  [[nodiscard]] MotionOptions options(const command::Cell& cell) const { return options_of(last(), cell, biases_); }
  [[nodiscard]] std::vector<std::optional<command::State>> abort_if(const command::Cell& cell) const {
    std::vector<std::optional<command::State>> states;
    for (const MotionTask& request : requests_) {
      states.push_back(request.abort_if ? std::optional(command::state_of(*request.abort_if, cell, biases_))
                                        : std::nullopt);
    }
    return states;
  }
  /// Values that one of the devices does not have.
  [[nodiscard]] Diagnostics wrong_springs(const command::Cell& cell) const {
    return last().compliance ? check_compliance(*last().compliance, cell, actuators()) : Diagnostics();
  }
  [[nodiscard]] std::unexpected<Diagnostics> nowhere() const {
    return failure(Code::kUnknownPosition, "",
                   fmt::format("'{}': the end position of the arm is unknown before the run", name()),
                   "a motion after the end of what runs");
  }
  [[nodiscard]] Surroundings surroundings(const PlanningContext& planning, const ActivityReview& review) const {
    return {.situation = [&planning] { return situation_before(planning); },
            .meanwhile = planning.beside.empty() ? meanwhile_ : review.meanwhile()};
  }
  static PlanningContext nothing_before(const command::Cell& cell) {
    return {.cell = cell, .period = kMillisecond, .predecessors = {}};
  }

 private:
  std::vector<MotionTask> requests_;
  command::Biases biases_;
  Meanwhile meanwhile_;
};

class OfOneArm final : public Requested {
 public:
  using Requested::Requested;

  [[nodiscard]] std::vector<std::string> actuators() const override { return {last().arm}; }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    const Predecessor& before = planning.predecessors.find(last().arm)->second;
    if (!before.at_end.rests()) return nowhere();
    if (const Diagnostics mixed = check_offsets(requests()); mixed.has_errors())
      return std::unexpected(of_motions(mixed, requests(), /*named=*/true));
    if (Diagnostics wrong = wrong_springs(planning.cell); wrong.has_errors()) return std::unexpected(std::move(wrong));
    ActivityReview review(requests(), planning);
    auto plan = plan_motions(requests(), planning.cell, *before.at_end.q, surroundings(planning, review));
    while (review.plan_again(plan))
      plan = plan_motions(requests(), planning.cell, *before.at_end.q, surroundings(planning, review));
    if (!plan) return std::unexpected(std::move(plan.error()));
    if (Diagnostics wrong = review.collisions(*plan); wrong.has_errors()) return std::unexpected(std::move(wrong));
    // What is laid over the first motion begins at rest.
    const Surroundings around = surroundings(planning, review);
    auto from_blend = requests().front().has_overlay() ? std::nullopt : blended_plan(planning, before, around);
    if (from_blend && !may_be_blended(planning, around, *plan, *from_blend)) from_blend.reset();
    return prepare(planning, std::move(*plan), std::move(from_blend));
  }

  [[nodiscard]] Result<Alone> alone(const command::Cell& cell, const Places& q,
                                    const Surroundings& surroundings) const override {
    if (const Diagnostics mixed = check_offsets(requests()); mixed.has_errors())
      return std::unexpected(of_motions(mixed, requests(), /*named=*/true));
    auto plan = plan_motions(requests(), cell, q.find(last().arm)->second, surroundings);
    if (!plan) return std::unexpected(std::move(plan.error()));
    Alone alone{.prepared = {},
                .notes = plan->notes,
                .q_goal = {{last().arm, plan->motion.q_goal}},
                .duration = plan->motion.duration()};
    auto prepared = prepare(nothing_before(cell), std::move(*plan), std::nullopt);
    if (!prepared) return std::unexpected(std::move(prepared.error()));
    alone.prepared = std::move(*prepared);
    return alone;
  }

 private:
  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning, motion::SequencePlan from_rest,
                                                std::optional<motion::SequencePlan> from_blend) const {
    const motion::ArmModel model = command::planning_model(planning.cell.arms.find(last().arm)->second);
    ArmPlans plans{.name = name(),
                   .arm = last().arm,
                   .model = model,
                   .from_rest = std::move(from_rest),
                   .from_blend = std::move(from_blend),
                   .abort_if = abort_if(planning.cell),
                   .weaves = weaves_of(requests()),
                   .offset = offset(planning.cell)};
    auto prepared = prepare_dual_entry(planning, std::move(plans), options(planning.cell));
    if (!prepared) return std::unexpected(of_motions(prepared.error(), requests()));
    return prepared;
  }

  [[nodiscard]] std::optional<OffsetPlan> offset(const command::Cell& cell) const {
    const auto first = first_offset(requests());
    if (!first) return std::nullopt;
    const ForceOffsetParameters& force = *requests()[*first].force_offset;
    return OffsetPlan{.pressing = force.pressing(last().arm, cell, biases()),
                      .parameters = force.control_parameters(cell),
                      .first = *first};
  }

  /// A corner must not be cut into something. Then the arm comes to rest at it.
  [[nodiscard]] bool may_be_blended(const PlanningContext& planning, const Surroundings& around,
                                    const motion::SequencePlan& from_rest,
                                    const motion::SequencePlan& from_blend) const {
    const motion::ArmModel model = command::planning_model(planning.cell.arms.find(last().arm)->second);
    return is_clear_blend(requests(), planning.cell, model, around, from_rest, from_blend);
  }

  [[nodiscard]] std::optional<motion::SequencePlan> blended_plan(const PlanningContext& planning,
                                                                 const Predecessor& before,
                                                                 const Surroundings& around) const {
    const command::MountedArm& arm = planning.cell.arms.find(last().arm)->second;
    const auto from = departure_of(before, arm.X_FT);
    if (!from) return std::nullopt;
    auto plan = plan_motions_from(*from, requests(), planning.cell, around);
    return plan ? std::optional(std::move(*plan)) : std::nullopt;
  }
};

/// They move the leader's tool centre point, which is the common motion centre.
class OfTwoArms final : public Requested {
 public:
  using Requested::Requested;

  [[nodiscard]] std::vector<std::string> actuators() const override { return {last().arm, last().follower}; }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    const Predecessor& leads = planning.predecessors.find(last().arm)->second;
    const Predecessor& follows = planning.predecessors.find(last().follower)->second;
    if (!leads.at_end.rests() || !follows.at_end.rests()) return nowhere();
    if (Diagnostics wrong = wrong_springs(planning.cell); wrong.has_errors()) return std::unexpected(std::move(wrong));
    auto grasp = grasp_at(planning.cell, last().arm, last().follower, *leads.at_end.q, *follows.at_end.q);
    if (!grasp) return std::unexpected(std::move(grasp.error()));
    // They hold the part as before, to the last bit.
    if (const auto* leaving = leaving_pair(planning, grasp->leader, grasp->follower))
      grasp->X_HF = leaving->motion.partner_X_FM;
    auto from_rest = plan(planning.cell, *grasp, *leads.at_end.q, *follows.at_end.q);
    if (!from_rest) return std::unexpected(std::move(from_rest.error()));
    auto from_blend = plan_pair_on(planning, *grasp, leg_makers(requests(), planning.cell));
    return prepare(planning, *grasp, std::move(*from_rest), std::move(from_blend));
  }

  [[nodiscard]] Result<Alone> alone(const command::Cell& cell, const Places& q, const Surroundings&) const override {
    const JointVector &q_leader = q.find(last().arm)->second, &q_follower = q.find(last().follower)->second;
    const auto grasp = grasp_at(cell, last().arm, last().follower, q_leader, q_follower);
    if (!grasp) return std::unexpected(grasp.error());
    auto from_rest = plan(cell, *grasp, q_leader, q_follower);
    if (!from_rest) return std::unexpected(std::move(from_rest.error()));
    Alone alone{.prepared = {},
                .notes = from_rest->notes,
                .q_goal = {{last().arm, from_rest->leader.q_goal}, {last().follower, from_rest->follower.q_goal}},
                .duration = from_rest->leader.duration()};
    alone.prepared = prepare(nothing_before(cell), *grasp, std::move(*from_rest), std::nullopt);
    return alone;
  }

 private:
  [[nodiscard]] Result<motion::PairPlan> plan(const command::Cell& cell, const Grasp& grasp,
                                              const JointVector& q_leader, const JointVector& q_follower) const {
    return plan_pair_motions(requests(), cell, pair_of(cell, grasp), q_leader, q_follower);
  }
  [[nodiscard]] PlannedActivity prepare(const PlanningContext& planning, const Grasp& grasp, motion::PairPlan from_rest,
                                        std::optional<motion::PairPlan> from_blend) const {
    PairPlans plans{.name = name(),
                    .grasp = grasp,
                    .from_rest = std::move(from_rest),
                    .from_blend = std::move(from_blend),
                    .abort_if = abort_if(planning.cell)};
    return prepare_dual_entry(planning, std::move(plans), options(planning.cell));
  }
};

}  // namespace

MotionOptions options_of(const MotionTask& motion, const command::Cell& cell, const command::Biases& biases) {
  MotionOptions options{.velocity = motion.velocity,
                        .acceleration = motion.acceleration,
                        .linear_velocity = motion.linear_velocity,
                        .blend = motion.blend,
                        .X_FM = motion.X_FM,
                        .weave = motion.weave};
  options.must_touch = motion.must_touch;
  if (motion.until) options.until = command::state_of(*motion.until, cell, biases);
  if (motion.abort_if) options.abort_if = command::state_of(*motion.abort_if, cell, biases);
  const int joint_count = cell.arms.find(motion.arm)->second.device->description().chain->joint_count();
  if (motion.compliance) options.compliance = compliance_of(*motion.compliance, joint_count);
  if (motion.force_offset)
    options.force_offset = HeldForce{.sensor = motion.force_offset->sensor,
                                     .pressing = motion.force_offset->pressing(motion.arm, cell, biases),
                                     .parameters = motion.force_offset->control_parameters(cell)};
  return options;
}

std::shared_ptr<const RequestedMotion> requested_motion(const std::vector<MotionTask>& requests, command::Biases biases,
                                                        Meanwhile meanwhile) {
  if (requests.front().follower.empty())
    return std::make_shared<const OfOneArm>(requests, std::move(biases), std::move(meanwhile));
  return std::make_shared<const OfTwoArms>(requests, std::move(biases), std::move(meanwhile));
}

}  // namespace takt::activity
