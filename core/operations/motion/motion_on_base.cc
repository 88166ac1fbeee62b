#include "core/operations/motion/motion_on_base.h"

#include <utility>

#include "core/command/actions/carried_motion.h"
#include "core/expression/moving_frames.h"
#include "core/kinematics/chain.h"
#include "core/operations/motion/motion_plan.h"

namespace takt::operations {
namespace {

using kinematics::JointVector;

/// Where the tool is to be, in the frame in which the base drives.
Result<Eigen::Isometry3d> tool_goal(const MotionTask& motion, const expression::Cell& cell, const std::string& base,
                                    const JointVector& q_base, const JointVector& q_arm) {
  const std::string& arm = motion.arm;
  const auto goal = resolve(motion.goal, cell, arm, q_arm);
  if (!goal) return std::unexpected(goal.error());
  const auto* joints = std::get_if<JointVector>(&*goal);
  const Eigen::Isometry3d X_AM =
      joints ? tool_pose(cell.arms.find(arm)->second, *joints) : std::get<Eigen::Isometry3d>(*goal);
  const Eigen::Isometry3d X_BF = cell.arms.find(base)->second.device->description().chain->forward(q_base);
  return Eigen::Isometry3d(X_BF * cell.frames.relation(arm)->X_PF * X_AM);
}

std::unexpected<Diagnostics> below(const char* place, const Diagnostics& found) {
  Diagnostics placed;
  placed.append(found, place);
  return std::unexpected(std::move(placed));
}

}  // namespace

Result<command::PlannedMotion> plan_on_base(const MotionTask& motion, const expression::Cell& now,
                                            const expression::Places& places) {
  const auto base = command::carrier_of(now, motion.arm);
  if (!base) return std::unexpected(base.error());
  const expression::Cell cell = expression::cell_at(now, places);
  const JointVector &q_base = places.at(*base), &q_arm = places.at(motion.arm);
  const auto X_goal = tool_goal(motion, cell, *base, q_base, q_arm);
  if (!X_goal) return below("/to", X_goal.error());
  Diagnostics ignored;  // a base turns as it is told, or not at all
  const auto q_goal = goal_joints(*motion.base_goal, cell, *base, q_base, ignored);
  if (!q_goal) return below("/base_to", q_goal.error());
  const command::PlanParameters parameters{
      .velocity = motion.velocity, .acceleration = motion.acceleration, .linear_velocity = motion.linear_velocity};
  auto planned = command::carried_lin(cell, motion.arm, {q_base, q_arm, *q_goal, *X_goal}, parameters);
  if (planned) return planned;
  // The planner speaks of goals, the file of keys.
  Diagnostics renamed;
  for (Diagnostic diagnostic : planned.error().list()) {
    diagnostic.pointer = diagnostic.pointer.starts_with("/carrier") ? "/base_to" : "/to";
    renamed.add(std::move(diagnostic));
  }
  return std::unexpected(std::move(renamed));
}

}  // namespace takt::operations
