#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/activity/activity_model.h"
#include "core/activity/motion_options.h"
#include "core/motion/plan_pair.h"

/// What motions of two arms as one are made of (docs/activity-layer.md). Realtime: setup.
namespace takt::activity {

/// How two arms hold one frame C, the common motion centre. Poses in m.
struct Grasp {
  std::string leader, follower;
  Eigen::Isometry3d X_WL, X_WF;  ///< bases of leader and follower
  Eigen::Isometry3d X_HL, X_HF;  ///< C in their flanges
};

/// As planners have them. It refers to the arms of the cell.
[[nodiscard]] motion::ArmPair pair_of(const expression::Cell& cell, const Grasp& grasp);

/// C is the leader's tool centre point, held as both are at these joints (rad or m). @return diagnostics: the arms
/// can not be one, with "/follower".
[[nodiscard]] Result<Grasp> grasp_at(const expression::Cell& cell, const std::string& leader,
                                     const std::string& follower, const kinematics::JointVector& q_leader,
                                     const kinematics::JointVector& q_follower);

/// A plan as the command layer carries it out, for arm_pair().
[[nodiscard]] command::PlannedMotion planned(const Grasp& grasp, std::string name, motion::PairPlan plan);

/// The plans of a motion of C.
struct PairPlans {
  std::string name;
  const Grasp& grasp;
  motion::PairPlan from_rest;
  std::optional<motion::PairPlan> from_blend;
  std::vector<std::optional<expression::State>> abort_if = {};
};
[[nodiscard]] PlannedActivity prepare_dual_entry(const PlanningContext& planning, PairPlans plans,
                                                 const MotionOptions& options);

/// The motion of the same two arms that may be left, and how they hold C in it; nothing: there is none.
[[nodiscard]] const Predecessor::BlendOut* leaving_pair(const PlanningContext& planning, const std::string& leader,
                                                        const std::string& follower);

/// Plans what goes on with the motion of this grasp that may be left; nothing where both come to rest first.
[[nodiscard]] std::optional<motion::PairPlan> plan_pair_on(const PlanningContext& planning, const Grasp& grasp,
                                                           const std::vector<motion::LegMaker>& makers);

}  // namespace takt::activity
