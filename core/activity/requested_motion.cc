#include "core/activity/requested_motion.h"

#include <utility>

#include <fmt/format.h>

#include "core/activity/two_ways.h"
#include "core/command/condition_state.h"

namespace takt::activity {

RequestedMotion::RequestedMotion(const std::vector<MotionRequest>& requests, command::Biases biases)
    : ActivityModel(requests.front().name), requests_(requests), biases_(std::move(biases)) {}

Result<Prepared> RequestedMotion::prepare(const Situation& situation) const {
  const Precedent& before = situation.precedents.find(requests_.back().arm)->second;
  if (!before.at_end.rests())
    return failure("", fmt::format("'{}': nobody knows where the arm will be at rest", name()),
                   "a motion after the end of what runs");
  auto plan = plan_motions(requests_, situation.cell, *before.at_end.q);
  if (!plan) return std::unexpected(std::move(plan.error()));
  return prepare(situation, std::move(*plan));
}

Prepared RequestedMotion::prepare(const Situation& situation, motion::SequencePlan from_rest) const {
  const MotionRequest& last = requests_.back();
  const motion::ArmModel model = command::planning_model(situation.cell.arms.find(last.arm)->second);
  MotionParameters wish{.blend = BlendingCondition(last.blend)};
  if (last.until) wish.until = command::state_of(*last.until, situation.cell, biases_);
  ArmPlans plans{name(), last.arm, model, std::move(from_rest), blended_plan(situation), /*tells_end=*/true};
  return prepare_two_ways(situation, std::move(plans), wish);
}

std::optional<motion::SequencePlan> RequestedMotion::blended_plan(const Situation& situation) const {
  const auto before = situation.precedents.find(requests_.back().arm);
  if (before == situation.precedents.end()) return std::nullopt;
  const command::MountedArm& arm = situation.cell.arms.find(requests_.back().arm)->second;
  const auto from = departure_of(before->second, arm.X_FT);
  if (!from) return std::nullopt;
  auto plan = plan_motions_from(*from, requests_, situation.cell);
  return plan ? std::optional(std::move(*plan)) : std::nullopt;
}

}  // namespace takt::activity
