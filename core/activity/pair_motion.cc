#include "core/activity/pair_motion.h"

#include <utility>

#include <fmt/format.h>

#include "core/activity/dual_entry_motion.h"
#include "core/expression/moving_frames.h"
#include "core/kinematics/chain.h"
#include "core/motion/motion_state.h"

namespace takt::activity {
namespace {

using expression::Cell;
using kinematics::JointVector;
using motion::ArmModel;

constexpr double kSame = 1e-12;  ///< of poses that are handed on and never computed anew

ArmModel model_of(const Cell& cell, const std::string& arm, const Eigen::Isometry3d& X_FM) {
  return expression::planning_model(cell.arms.find(arm)->second, X_FM);
}

void add_blend(const PlanningContext& planning, const PairPlans& plans, motion::PairPlan plan, DualEntryMotion& dual) {
  const motion::ArmPair pair = pair_of(planning.cell, plans.grasp);
  const auto first = motion::joints_at(pair.leader, plan.leader, 0.0);
  const auto second = motion::joints_at(pair.follower, plan.follower, 0.0);
  const Predecessor::BlendOut* leaving = leaving_pair(planning, plans.grasp.leader, plans.grasp.follower);
  if (!first || !second || leaving == nullptr) return;
  dual.begins[plans.grasp.leader].blend = seam_in_motion(*leaving, *first);
  dual.begins[plans.grasp.follower].blend = seam_in_motion(*leaving, *second);
  dual.tau = leaving->tau;
  dual.from_blend = planned(plans.grasp, plans.name, std::move(plan));
}

}  // namespace

motion::ArmPair pair_of(const Cell& cell, const Grasp& grasp) {
  return {.leader = model_of(cell, grasp.leader, grasp.X_HL),
          .follower = model_of(cell, grasp.follower, grasp.X_HF),
          .X_FL = grasp.X_WF.inverse() * grasp.X_WL};
}

Result<Grasp> grasp_at(const Cell& cell, const std::string& leader, const std::string& follower,
                       const JointVector& q_leader, const JointVector& q_follower) {
  if (expression::moves(cell.frames, leader, follower)) {
    return failure(Code::kUnknownPosition, "/follower",
                   fmt::format("the pose of '{}' relative to '{}' changes while a base drives", follower, leader),
                   "Name arms that are fixed in the cell, or on one base");
  }
  const expression::MountedArm &leads = cell.arms.find(leader)->second, &follows = cell.arms.find(follower)->second;
  const auto X_WL = cell.frames.pose(leader), X_WF = cell.frames.pose(follower);
  if (!X_WL) return std::unexpected(X_WL.error());
  if (!X_WF) return std::unexpected(X_WF.error());
  const Eigen::Isometry3d X_WC = *X_WL * leads.device->description().chain->forward(q_leader) * leads.X_FT;
  const Eigen::Isometry3d X_WH = *X_WF * follows.device->description().chain->forward(q_follower);
  return Grasp{.leader = leader,
               .follower = follower,
               .X_WL = *X_WL,
               .X_WF = *X_WF,
               .X_HL = leads.X_FT,
               .X_HF = X_WH.inverse() * X_WC};
}

command::PlannedMotion planned(const Grasp& grasp, std::string name, motion::PairPlan plan) {
  return {
      .motion = std::make_shared<const motion::Motion>(std::move(plan.leader)),
      .X_FM = grasp.X_HL,
      .handed_over = std::move(plan.handed_over),
      .clock = {},
      .name = std::move(name),
      .partner = command::PlannedPartner{std::make_shared<const motion::Motion>(std::move(plan.follower)), grasp.X_HF}};
}

PlannedActivity prepare_dual_entry(const PlanningContext& planning, PairPlans plans, const MotionOptions& options) {
  DualEntryMotion dual{.name = plans.name,
                       .actuator = command::arm_pair(planning.cell, plans.grasp.leader, plans.grasp.follower),
                       .clock = plans.grasp.leader,
                       .from_rest = planned(plans.grasp, plans.name, std::move(plans.from_rest)),
                       .abort_if = std::move(plans.abort_if)};
  dual.begins[plans.grasp.leader].rest = seam_at_rest(dual.from_rest.motion->q_start);
  dual.begins[plans.grasp.follower].rest = seam_at_rest(dual.from_rest.partner->motion->q_start);
  if (plans.from_blend) add_blend(planning, plans, std::move(*plans.from_blend), dual);
  return prepare_dual_entry(planning, std::move(dual), options);
}

const Predecessor::BlendOut* leaving_pair(const PlanningContext& planning, const std::string& leader,
                                          const std::string& follower) {
  const auto leads = planning.predecessors.find(leader), follows = planning.predecessors.find(follower);
  if (leads == planning.predecessors.end() || follows == planning.predecessors.end()) return nullptr;
  const auto &one = leads->second.leaving, &two = follows->second.leaving;
  const bool together = one && two && one->motion.arm == leader && one->motion.partner != nullptr &&
                        one->motion.motion == two->motion.motion;
  return together ? &*one : nullptr;
}

std::optional<motion::PairPlan> plan_pair_on(const PlanningContext& planning, const Grasp& grasp,
                                             const std::vector<motion::LegMaker>& makers) {
  const Predecessor::BlendOut* leaving = leaving_pair(planning, grasp.leader, grasp.follower);
  if (leaving == nullptr) return std::nullopt;
  const BlendSource& before = leaving->motion;
  // Another frame, held elsewhere, does not go on from this one.
  if (!before.X_FM.isApprox(grasp.X_HL, kSame) || !before.partner_X_FM.isApprox(grasp.X_HF, kSame)) return std::nullopt;
  auto plan = motion::plan_pair_take_over(
      pair_of(planning.cell, grasp),
      {.motion = *before.motion, .tau = leaving->tau, .lead = leaving->lead, .blend = before.blend}, *before.partner,
      makers);
  return plan ? std::optional(std::move(*plan)) : std::nullopt;
}

}  // namespace takt::activity
