#pragma once

#include <vector>

#include "core/motion/leg.h"

namespace takt::motion {

/// Two arms that move one frame C, the common motion centre: `leader.X_FM` and `follower.X_FM` are C in their flanges.
struct ArmPair {
  ArmModel leader, follower;
  Eigen::Isometry3d X_FL = Eigen::Isometry3d::Identity();  ///< the leader's base seen from the follower's
};

/// One law and one clock for both; at each s both paths have C at the same place.
struct PairPlan {
  Motion leader, follower;
  std::vector<double> handed_over;  ///< as in SequencePlan
  Diagnostics notes = {};           ///< ...
};

/// Plans motions of C as the leader sees them, and brings the follower along: the law is stretched until both keep
/// their limits.
/// @return the plan, or diagnostics of either arm ("/follower" before those of the other). Realtime: setup,
/// deterministic.
[[nodiscard]] Result<PairPlan> plan_pair(const ArmPair& pair, const JointVector& q_leader,
                                         const JointVector& q_follower, const std::vector<LegMaker>& makers);

/// The same for a pair in motion. A law that begins in motion cannot be stretched: where the follower cannot follow,
/// slower motions are tried.
/// @param from        the leader's motion   @param follower  that of the other arm, with the same law
[[nodiscard]] Result<PairPlan> plan_pair_take_over(const ArmPair& pair, const Departure& from, const Motion& follower,
                                                   const std::vector<LegMaker>& makers);

}  // namespace takt::motion
