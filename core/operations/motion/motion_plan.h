#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/motion/plan_pair.h"
#include "core/operations/motion/motion.h"
#include "core/operations/motion/move_plan.h"

/// From the parameters of motions to plans. Realtime: setup.
namespace takt::operations {

/// Where it leads to, or how, changes while machines move: a goal in a frame that does.
[[nodiscard]] bool depends_on_moving_frame(const MotionTask& request, const expression::Cell& cell);

/// Where a goal of an arm or a base lies in its joints: of a pose the solution next to q. `notes` tells how much an arm
/// of few joints is turned away from it. @return diagnostics without a place: unknown frame, out of reach. Realtime:
/// setup.
[[nodiscard]] Result<kinematics::JointVector> goal_joints(const Goal& goal, const expression::Cell& cell,
                                                          const std::string& arm, const kinematics::JointVector& q,
                                                          Diagnostics& notes);

/// What is laid over each of them.
[[nodiscard]] command::Weaves weaves_of(const std::vector<MotionTask>& requests);
/// The first motion with a force offset; nothing: none has one.
[[nodiscard]] std::optional<std::size_t> first_offset(const std::vector<MotionTask>& requests);
/// A force offset may begin in a blend, but not change or end in one, and there is no weave in the same plan.
/// @return diagnostics "/1/force_offset" (index of the motion) that name both places
[[nodiscard]] Diagnostics check_offsets(const std::vector<MotionTask>& requests);
/// Diagnostics of motions by number, "/1/ramp", as a program has them: below the step of the first; those of a later
/// one are named in the text.
/// @param named  they name their motions themselves
[[nodiscard]] Diagnostics of_motions(const Diagnostics& diagnostics, const std::vector<MotionTask>& requests,
                                     bool named = false);
/// Notes of a planner, "/1/blend", at the key of that motion in the file. One without a number is of the first motion,
/// one with a number that no motion has of the last.
[[nodiscard]] Diagnostics notes_of_motions(const Diagnostics& notes, const std::vector<MotionTask>& requests);

/// Plans one motion, or several that follow each other and are blended, from q (rad or m) as things are believed to be.
/// @param surroundings  what a `move` avoids; empty: machines where they are now
/// @return the plan, or diagnostics with pointers below the step of the first motion; those of a later one are named in
/// the text. Notes of the plan have the pointers of the file. Realtime: setup.
[[nodiscard]] Result<motion::SequencePlan> plan_motions(const std::vector<MotionTask>& requests,
                                                        const expression::Cell& cell, const kinematics::JointVector& q,
                                                        const Surroundings& surroundings = {});

/// Plans the same from a motion of this arm that is being carried out (motion::plan_take_over). @return the plan, or
/// why it has to wait for the end of that one; pointers are the planner's. Realtime: setup.
[[nodiscard]] Result<motion::SequencePlan> plan_motions_from(const motion::Departure& from,
                                                             const std::vector<MotionTask>& requests,
                                                             const expression::Cell& cell,
                                                             const Surroundings& surroundings = {});

/// Geometry of motions as planners want it. It refers to the requests and the cell.
[[nodiscard]] std::vector<motion::LegMaker> leg_makers(const std::vector<MotionTask>& requests,
                                                       const expression::Cell& cell,
                                                       const Surroundings& surroundings = {});

/// Plans motions of two arms as one: of the leader's tool centre point, from where both stand. Diagnostics as of
/// plan_motions(), those of the second arm at "/follower". Realtime: setup.
[[nodiscard]] Result<motion::PairPlan> plan_pair_motions(const std::vector<MotionTask>& requests,
                                                         const expression::Cell& cell, const motion::ArmPair& pair,
                                                         const kinematics::JointVector& q_leader,
                                                         const kinematics::JointVector& q_follower);

}  // namespace takt::operations
