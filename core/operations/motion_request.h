#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/expression/condition.h"
#include "core/motion/plan_pair.h"
#include "core/operations/compliance_request.h"
#include "core/operations/goal.h"
#include "core/operations/overlay_request.h"

namespace takt::activity {

enum class PathKind { kPtp, kLin, kCirc, kSpline };

/// What a motion step says, in numbers. Keys: docs/scenarios.md.
struct MotionRequest : OperationHead {
  /// CIRC about an axis in place of a goal.
  struct About {
    std::string in = "world";
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< in that frame, m
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   ///< in that frame
    double angle = 0.0;                                ///< rad
  };

  PathKind kind = PathKind::kPtp;
  std::string arm;
  std::string follower;  ///< a second arm that moves as one with it; empty: none
  Goal goal;             ///< all but splines, and arcs about an axis
  std::optional<Goal> via;
  std::optional<About> about;
  motion::ArcOrientation orientation = motion::ArcOrientation::kToGoal;
  std::vector<Goal> through;
  double velocity = 1.0;                  ///< shares of the limits
  double acceleration = 1.0;              ///< ...
  std::optional<double> linear_velocity;  ///< m/s
  motion::Blend blend;
  std::optional<ComplianceRequest> compliance;
  OverlayRequest overlay;
  std::optional<command::Condition> until;
  bool must_touch = true;                    ///< a guarded motion that reaches its end is a failure
  std::optional<command::Condition> unless;  ///< as soon as it holds the motion brakes on its path and has failed
};

/// The arms that motions move, as one name.
[[nodiscard]] std::string moved_by(const MotionRequest& request);

[[nodiscard]] const ParameterTable<MotionRequest>& motion_parameters(PathKind kind);

/// Reads a step. Diagnostics: all that is wrong with its form.
[[nodiscard]] MotionRequest read_motion(PathKind kind, const nlohmann::ordered_json& json, const std::string& pointer,
                                        const command::Cell& cell, Diagnostics& diagnostics);

/// Where it leads to, or how, changes while machines move: a goal in a frame that does.
[[nodiscard]] bool depends_on_moving_frame(const MotionRequest& request, const command::Cell& cell);

/// Where a goal of an arm or a base lies in its joints: of a pose the solution next to q. `notes` tells how much an arm
/// of few joints is turned away from it. @return diagnostics without a place: unknown frame, out of reach. Realtime:
/// setup.
[[nodiscard]] Result<kinematics::JointVector> goal_joints(const Goal& goal, const command::Cell& cell,
                                                          const std::string& arm, const kinematics::JointVector& q,
                                                          Diagnostics& notes);

/// What is laid over each of them.
[[nodiscard]] command::WeaveWishes weaves_of(const std::vector<MotionRequest>& requests);
/// The first motion with a force offset; nothing: none has one.
[[nodiscard]] std::optional<std::size_t> first_offset(const std::vector<MotionRequest>& requests);
/// A force offset may begin in a blend, but not change or end in one, and there is no weave in the same plan.
/// @return diagnostics "/1/force_offset" (index of the motion) that name both places
[[nodiscard]] Diagnostics check_offsets(const std::vector<MotionRequest>& requests);
/// Diagnostics of motions by number, "/1/ramp", as a program has them: below the step of the first; those of a later
/// one are named in the text.
[[nodiscard]] Diagnostics of_motions(const Diagnostics& diagnostics, const std::vector<MotionRequest>& requests);

/// Plans one motion, or several that follow each other and are blended, from q (rad or m) as things are believed to be.
/// @return the plan, or diagnostics with pointers below the step of the first motion; those of a later one are named in
/// the text. Notes of the plan have the pointers of the file. Realtime: setup.
[[nodiscard]] Result<motion::SequencePlan> plan_motions(const std::vector<MotionRequest>& requests,
                                                        const command::Cell& cell, const kinematics::JointVector& q);

/// Plans the same from a motion of this arm that is being carried out (motion::plan_take_over). @return the plan, or
/// why it has to wait for the end of that one; pointers are the planner's. Realtime: setup.
[[nodiscard]] Result<motion::SequencePlan> plan_motions_from(const motion::Departure& from,
                                                             const std::vector<MotionRequest>& requests,
                                                             const command::Cell& cell);

/// Geometry of motions as planners want it. It refers to both.
[[nodiscard]] std::vector<motion::LegMaker> leg_makers(const std::vector<MotionRequest>& requests,
                                                       const command::Cell& cell);

/// Plans motions of two arms as one: of the leader's tool centre point, from where both stand. Diagnostics as of
/// plan_motions(), those of the second arm at "/follower". Realtime: setup.
[[nodiscard]] Result<motion::PairPlan> plan_pair_motions(const std::vector<MotionRequest>& requests,
                                                         const command::Cell& cell, const motion::ArmPair& pair,
                                                         const kinematics::JointVector& q_leader,
                                                         const kinematics::JointVector& q_follower);

}  // namespace takt::activity
