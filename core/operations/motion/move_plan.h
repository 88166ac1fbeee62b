#pragma once

#include <functional>
#include <optional>

#include "core/activity/meanwhile.h"
#include "core/collision/contact_rules.h"
#include "core/expression/believed_shapes.h"
#include "core/operations/motion/motion.h"

/// Motions that avoid obstacles (docs/planning.md). Realtime: setup.
namespace takt::operations {

/// What motions that look where they can go find there.
struct Surroundings {
  std::function<collision::CellState()> situation = {};  ///< the cell as it is believed to be when they begin
  activity::ConcurrentMotions meanwhile = {};            ///< what others do while they are carried out

  explicit operator bool() const { return situation != nullptr; }
};

/// Machines where they are now, but for those that are named. It refers to the cell.
/// @param widths  of grippers, m; default: as they are measured
[[nodiscard]] Surroundings surroundings_at(const expression::Cell& cell, expression::Places places,
                                           std::optional<expression::FingerWidths> widths = {});

/// The geometry of a `move` from q (rad or m): a path that is proven to be free, with round corners.
/// @return the leg, without shares and blend; or diagnostics "/to": out of reach; the code collision: in collision at
/// the start or at each goal; planning-failed: no path was found, and what is most in the way. All name both bodies,
/// and of one that moves meanwhile its motion and when that is.
[[nodiscard]] Result<motion::Leg> move_leg(const MotionTask& request, const expression::Cell& cell,
                                           const kinematics::JointVector& q, const Surroundings& surroundings);

/// The goal of a PTP with `solution` "free": of the joint configurations with its pose the nearest whose whole path
/// from q is free. @return the goal, or diagnostics "/to" as of move_leg()
[[nodiscard]] Result<kinematics::JointVector> free_solution(const MotionTask& request, const expression::Cell& cell,
                                                            const kinematics::JointVector& q,
                                                            const Surroundings& surroundings);

}  // namespace takt::operations
