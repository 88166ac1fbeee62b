#include "core/motion/plan_pair.h"

#include <cmath>
#include <utility>

#include "core/kinematics/inverse.h"
#include "core/motion/motion_state.h"
#include "core/motion/path_planner.h"
#include "core/motion/path_transform.h"

namespace takt::motion {
namespace {

Result<PathFit> fit_of(const ArmModel& arm, const Motion& motion) { return PathPlanner(arm).fit(motion, "/goal"); }

Findings of_follower(const Findings& findings) {
  Findings all;
  all.append(findings, "/follower");
  return all;
}

/// The follower's motion beside the leader's, with the same law.
Result<Motion> beside(const ArmPair& pair, const Motion& leader, const JointVector& q_follower) {
  const auto path = seen_from(leader.path, pair.X_FL, pair.follower.inverse->held(q_follower));
  if (!path)
    return failure("/follower", "two arms move together on paths of a frame only", "LIN, CIRC, a spline of poses");
  Motion motion = leader;
  motion.path = *path;
  motion.q_start = motion.q_goal = q_follower;
  return motion;
}

/// Law and clock that suit both, the law `stretch` times as long.
Result<PairPlan> finish(const ArmPair& pair, Motion leader, Motion follower, double stretch) {
  leader.law = follower.law = stretch == 1.0 ? leader.law : leader.law.stretched(stretch);
  auto first = fit_of(pair.leader, leader), second = fit_of(pair.follower, follower);
  if (!first) return std::unexpected(std::move(first.error()));
  if (!second) return std::unexpected(of_follower(second.error()));
  leader.clock = follower.clock = common(first->clock, second->clock);
  leader.q_goal = first->q_goal;
  follower.q_goal = second->q_goal;
  return PairPlan{std::move(leader), std::move(follower), {}};
}

bool has_both(const ArmPair& pair, Findings& findings) {
  for (const ArmModel* arm : {&pair.leader, &pair.follower})
    if (arm->inverse == nullptr) findings.error("/goal", "an arm of the pair has no inverse kinematics");
  return !findings.has_errors();
}

}  // namespace

Result<PairPlan> plan_pair(const ArmPair& pair, const JointVector& q_leader, const JointVector& q_follower,
                           const std::vector<LegMaker>& makers) {
  Findings findings;
  if (!has_both(pair, findings)) return std::unexpected(std::move(findings));
  auto alone = plan_sequence(pair.leader, q_leader, makers);
  if (!alone) return std::unexpected(std::move(alone.error()));
  auto follower = beside(pair, alone->motion, q_follower);
  if (!follower) return std::unexpected(std::move(follower.error()));
  if (alone->motion.duration() == 0.0) {
    alone->motion.q_goal = q_leader;
    return PairPlan{std::move(alone->motion), std::move(*follower), {}};
  }
  const auto fit = fit_of(pair.follower, *follower);
  if (!fit) return std::unexpected(of_follower(fit.error()));
  const double stretch = std::max(1.0, fit->stretch);
  auto plan = finish(pair, std::move(alone->motion), std::move(*follower), stretch);
  if (!plan) return plan;
  for (const double tau : alone->handed_over) plan->handed_over.push_back(stretch * tau);
  return plan;
}

Result<PairPlan> plan_pair_take_over(const ArmPair& pair, const Departure& from, const Motion& follower_before,
                                     const std::vector<LegMaker>& makers) {
  const auto q_follower = joints_at(pair.follower, follower_before, from.tau);
  if (!q_follower) return failure("/follower", "nobody knows where it will be");
  Result<PairPlan> plan = failure("/blend", "no blend was tried");
  for (const double share : {1.0, 0.8, 0.6}) {
    std::vector<LegMaker> slower;
    for (const LegMaker& maker : makers) {
      slower.push_back([&maker, share](const JointVector& q) {
        auto leg = maker(q);
        if (leg) {
          leg->velocity *= share;
          leg->acceleration *= share * share;
        }
        return leg;
      });
    }
    auto alone = plan_take_over(pair.leader, from, slower);
    if (!alone) return std::unexpected(std::move(alone.error()));
    auto follower = beside(pair, alone->motion, q_follower->q);
    if (!follower) return std::unexpected(std::move(follower.error()));
    const auto fit = fit_of(pair.follower, *follower);
    if (!fit) return std::unexpected(of_follower(fit.error()));
    if (!fit->leaves_room) {
      plan = failure("/follower", "it cannot follow at the speed of the leader");
      continue;
    }
    return finish(pair, std::move(alone->motion), std::move(*follower), 1.0);
  }
  return plan;
}

}  // namespace takt::motion
