#include "core/command/actions/carried_motion.h"

#include <limits>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "core/kinematics/plane.h"
#include "core/motion/plan_carried.h"

namespace takt::command {
Result<std::string> carrier_of(const expression::Cell& cell, const std::string& arm) {
  const world::Relation* relation = cell.frames.relation(arm);
  if (relation != nullptr && relation->kind == world::Relation::Kind::kFlange) {
    const auto carrier = cell.arms.find(relation->source);
    const bool drives =
        carrier != cell.arms.end() && kinematics::moves_in_plane(*carrier->second.device->description().chain);
    if (drives) return relation->source;
  }
  return failure(Code::kRequires, "/arm", fmt::format("'{}' is not mounted on a base", arm),
                 "Name an arm that is mounted \"on\" a base");
}

Actuator arm_on_base(const expression::Cell& cell, const std::string& arm) {
  const auto base = carrier_of(cell, arm);
  return base ? carried_pair(cell, *base, arm) : missing(arm, base.error().list().front());
}

Result<PlannedMotion> carried_lin(const expression::Cell& cell, const std::string& arm, const CarriedGoal& goal,
                                  const PlanParameters& parameters) {
  const auto base = carrier_of(cell, arm);
  if (!base) return std::unexpected(base.error());
  const expression::MountedArm& rider = cell.arms.find(arm)->second;
  const Eigen::Isometry3d X_FM = parameters.X_FM.value_or(rider.X_FT);
  const motion::CarriedArm both{
      .carrier = expression::planning_model(cell.arms.find(*base)->second, Eigen::Isometry3d::Identity()),
      .rider = expression::planning_model(rider, X_FM),
      .X_FA = cell.frames.relation(arm)->X_PF};
  const motion::PieceShares shares{
      .velocity = parameters.velocity,
      .acceleration = parameters.acceleration,
      .linear_velocity = parameters.linear_velocity.value_or(std::numeric_limits<double>::infinity())};
  auto plan = motion::plan_carried_lin(both, goal.q_base, goal.q_arm, goal.q_base_goal, goal.X_BM_goal, shares);
  if (!plan) return std::unexpected(std::move(plan.error()));
  return PlannedMotion{
      .motion = std::make_shared<const motion::Motion>(std::move(plan->leader)),
      .X_FM = Eigen::Isometry3d::Identity(),
      .handed_over = {},
      .clock = parameters.clock,
      .name = *base + "+" + arm + " LIN",
      .partner = PlannedPartner{std::make_shared<const motion::Motion>(std::move(plan->follower)), X_FM}};
}

}  // namespace takt::command
