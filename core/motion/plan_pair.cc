#include "core/motion/plan_pair.h"

#include <cmath>
#include <utility>

#include "core/kinematics/inverse.h"
#include "core/motion/motion_state.h"
#include "core/motion/path_planner.h"
#include "core/motion/path_transform.h"

namespace takt::motion {
namespace {

Diagnostics of_follower(const Diagnostics& diagnostics) {
  Diagnostics all;
  all.append(diagnostics, "/follower");
  return all;
}

/// The follower's motion beside the leader's, with the same law.
Result<Motion> beside(const ArmPair& pair, const Motion& leader, const JointVector& q_follower) {
  const auto path = seen_from(leader.path, pair.X_FL, pair.follower.inverse->held(q_follower));
  if (!path)
    return failure(Code::kConflict, "/follower", "two arms move together on paths of a frame only",
                   "Use LIN, CIRC or a spline of poses");
  Motion motion = leader;
  motion.path = *path;
  motion.q_start = motion.q_goal = q_follower;
  return motion;
}

/// The follower's motion as its arm follows it; diagnostics are told of the follower.
Result<FollowedPath> follow_beside(const ArmPair& pair, const Motion& follower) {
  auto path = PathPlanner(pair.follower).follow(follower, "/goal");
  if (!path) return std::unexpected(of_follower(path.error()));
  return path;
}

/// Clock and goals that suit both. @param fit  of the follower with the law that both have
Result<PairPlan> finish(const ArmPair& pair, Motion leader, Motion follower, const PathFit& fit) {
  const PathPlanner planner(pair.leader);
  const auto path = planner.follow(leader, "/goal");
  if (!path) return std::unexpected(path.error());
  leader.clock = follower.clock = common(planner.fit(*path, leader).clock, fit.clock);
  leader.q_goal = path->q_goal;
  follower.q_goal = fit.q_goal;
  return PairPlan{std::move(leader), std::move(follower), {}};
}

/// What the leader's plan says beside its motion, the law `stretch` times as long.
void add_rest(const SequencePlan& alone, double stretch, PairPlan& plan) {
  for (const double tau : alone.handed_over) plan.handed_over.push_back(stretch * tau);
  plan.notes = alone.notes;
}

bool has_both(const ArmPair& pair, Diagnostics& diagnostics) {
  for (const auto& [arm, place] : {std::pair(&pair.leader, "/goal"), {&pair.follower, "/follower"}}) {
    if (arm->inverse == nullptr)
      diagnostics.error(Code::kRequires, place, "an arm of the pair has no inverse kinematics",
                        "Name an arm of three joints at least");
  }
  return !diagnostics.has_errors();
}

}  // namespace

Result<PairPlan> plan_pair(const ArmPair& pair, const JointVector& q_leader, const JointVector& q_follower,
                           const std::vector<LegMaker>& makers) {
  Diagnostics diagnostics;
  if (!has_both(pair, diagnostics)) return std::unexpected(std::move(diagnostics));
  auto alone = plan_sequence(pair.leader, q_leader, makers);
  if (!alone) return std::unexpected(std::move(alone.error()));
  auto follower = beside(pair, alone->motion, q_follower);
  if (!follower) return std::unexpected(std::move(follower.error()));
  if (alone->motion.duration() == 0.0) {
    alone->motion.q_goal = q_leader;
    return PairPlan{std::move(alone->motion), std::move(*follower), std::move(alone->handed_over), alone->notes};
  }
  const auto path = follow_beside(pair, *follower);
  if (!path) return std::unexpected(path.error());
  const PathPlanner planner(pair.follower);
  PathFit fit = planner.fit(*path, *follower);
  const double stretch = std::max(1.0, fit.stretch);
  if (stretch > 1.0) {
    alone->motion.law = follower->law = follower->law.stretched(stretch);
    fit = planner.fit(*path, *follower);
  }
  auto plan = finish(pair, std::move(alone->motion), std::move(*follower), fit);
  if (plan) add_rest(*alone, stretch, *plan);
  return plan;
}

Result<PairPlan> plan_pair_take_over(const ArmPair& pair, const Departure& from, const Motion& follower_before,
                                     const std::vector<LegMaker>& makers) {
  const auto q_follower = joints_at(pair.follower, follower_before, from.tau);
  if (!q_follower) return failure(Code::kUnknownPosition, "/follower", "its position is unknown");
  Result<PairPlan> plan = failure(Code::kPlanningFailed, "/blend", "no blend was tried");
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
    const auto path = follow_beside(pair, *follower);
    if (!path) return std::unexpected(path.error());
    const PathFit fit = PathPlanner(pair.follower).fit(*path, *follower);
    if (!fit.leaves_room) {
      plan = failure(Code::kLimitExceeded, "/follower", "it cannot follow at the speed of the leader");
      continue;
    }
    plan = finish(pair, std::move(alone->motion), std::move(*follower), fit);
    if (plan) add_rest(*alone, 1.0, *plan);
    return plan;
  }
  return plan;
}

}  // namespace takt::motion
