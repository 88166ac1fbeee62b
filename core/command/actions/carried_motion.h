#pragma once

#include <string>

#include "core/command/actions/motion_action.h"
#include "core/command/actuator.h"

/// An arm on a base as one actuator (docs/command-layer.md). Realtime: setup.
namespace takt::command {

/// Name of the base that carries the arm: what the arm's frame rides on. @return a diagnostic where none does.
[[nodiscard]] Result<std::string> carrier_of(const expression::Cell& cell, const std::string& arm);

/// The base and the arm as one: "base+arm". An arm that is not there, or on no base, gives one that every check
/// refuses.
[[nodiscard]] Actuator arm_on_base(const expression::Cell& cell, const std::string& arm);

/// From where to where the two go. Sizes: joints of the base and of the arm.
struct CarriedGoal {
  kinematics::JointVector q_base, q_arm;  ///< set points at the start, rad or m
  kinematics::JointVector q_base_goal;    ///< x, y, yaw
  Eigen::Isometry3d X_BM_goal;  ///< of the frame that moves (parameters.X_FM, or the tool) in the base's frame, m
};
/// LIN of the tool in the room while the base drives (motion::plan_carried_lin), for arm_on_base().
/// @return the motion of the base with that of the arm as its partner; or diagnostics.
[[nodiscard]] Result<PlannedMotion> carried_lin(const expression::Cell& cell, const std::string& arm,
                                                const CarriedGoal& goal, const PlanParameters& parameters = {});

}  // namespace takt::command
