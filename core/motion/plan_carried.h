#pragma once

#include "core/motion/plan_pair.h"

namespace takt::motion {

/// An arm on a base that drives in the plane: `carrier` has the joints x, y, yaw, `rider` is the arm.
struct CarriedArm {
  ArmModel carrier, rider;                                 ///< `rider.X_FM` is the frame that goes straight
  Eigen::Isometry3d X_FA = Eigen::Isometry3d::Identity();  ///< the arm's base on the carrier's body, m
};

/// Plans LIN of the tool in the room while the base drives: the base in proportion (its own LIN), the arm along the
/// line as it is seen from the moving base; one law and one clock for both, as fast as the slower of the two allows.
/// @param q_carrier_goal  where the base ends; like q_carrier, it stands and the arm alone moves
/// @param X_BM_goal       of M in the frame in which the base moves
/// @param shares          of both; the linear velocity is that of M on its line in the room
/// @return the base as leader, the arm as follower; or diagnostics: those of plan_ptp for the base ("/carrier/..."),
/// those of a line for the arm. Realtime: setup, deterministic.
[[nodiscard]] Result<PairPlan> plan_carried_lin(const CarriedArm& both, const JointVector& q_carrier,
                                                const JointVector& q_rider, const JointVector& q_carrier_goal,
                                                const Eigen::Isometry3d& X_BM_goal, const PieceShares& shares = {});

}  // namespace takt::motion
