#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/activity/motion_options.h"
#include "core/expression/condition_state.h"
#include "core/motion/leg.h"
#include "core/operations/table/compliance.h"
#include "core/operations/table/goal.h"
#include "core/operations/table/operation.h"
#include "core/operations/table/overlay.h"
#include "core/operations/table/tool_choice.h"

namespace takt::operations {

enum class PathKind { kPtp, kLin, kCirc, kSpline, kMove };

/// How a planned motion is carried out. Shares are of the limits of the arm. No member is a text: programs write this
/// between braces inside of co_await expressions, where GCC 12 moves texts bit by bit.
struct MotionParameters {
  double velocity = 1.0, acceleration = 1.0;   ///< (0, 1]; files: speed, acceleration
  std::optional<double> linear_velocity = {};  ///< of the tool centre point, m/s
  activity::BlendingCondition blend = {};      ///< into the motion after it; not with `until`
  /// The arm brakes on its path when this holds (or nobody knows, row N3): a guarded motion.
  std::optional<expression::StateSource> until = {};
  /// As soon as it holds the arm brakes on its path, and the motion has failed.
  std::optional<expression::StateSource> abort_if = {};
  std::optional<Eigen::Isometry3d> X_FM = {};  ///< programs: the frame that moves, in the flange; default: the tool
  /// How the arm gives way meanwhile; it has to be in that control mode. Default: as the arm is.
  std::optional<ComplianceParameters> compliance = {};
  /// Laid over the path, which has at most kShareWithOverlay of the accelerations then. Neighbours in one plan hand a
  /// weave on (command::plan_weaves); where the next motion takes over in the run it ends at rest before.
  std::optional<command::WeaveParameters> weave = {};
  std::optional<ForceOffsetParameters> force_offset = {};
  bool must_touch = true;  ///< "on_end": a guarded step that reaches its goal is a failure

  [[nodiscard]] bool blends() const { return blend.along_path.kind != motion::Blend::Kind::kNone; }
  [[nodiscard]] bool has_overlay() const { return weave || force_offset; }
};

/// How a `move` looks for its path.
struct AvoidanceParameters {
  double clearance = 4e-3;  ///< m: kept beyond the margin of the cell, where start and goal allow it
  std::int64_t seed = 1;    ///< of all that is random: the same seed finds the same path
  double effort = 1.0;      ///< how long it is looked for; 1: 100 000 postures
};

/// The same, and where it goes: files say it with the rest, programs by the method that they call.
struct MotionTask : MotionParameters {
  /// CIRC about an axis in place of a goal.
  struct About {
    std::string in = "world";
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< in that frame, m
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   ///< in that frame
    double angle = 0.0;                                ///< rad
  };
  PathKind kind = PathKind::kPtp;
  std::string arm = {};       ///< empty: the only one
  std::string follower = {};  ///< a second arm that moves as one with it; empty: none
  /// Programs: the frame that moves, in the follower's flange; default: where it is when the motion begins.
  std::optional<Eigen::Isometry3d> X_HF = {};
  ToolChoice tool = {};  ///< of the arm, which leads; default: the one that the cell declares
  Goal goal = {};        ///< all but splines, and arcs about an axis
  std::optional<Goal> via = {};
  std::optional<About> about = {};
  motion::ArcOrientation orientation = motion::ArcOrientation::kToGoal;
  std::vector<Goal> through = {};
  AvoidanceParameters avoidance = {};   ///< move
  bool free_solution = false;           ///< PTP: to the nearest configuration whose path is free
  std::optional<Goal> base_goal = {};   ///< LIN: where the base that carries the arm drives meanwhile
  std::string name = {}, pointer = {};  ///< for people; in its file
};

/// The arms that motions move, as one name.
[[nodiscard]] std::string moved_by(const MotionTask& request);

[[nodiscard]] const ParameterTable<MotionTask>& motion_parameters(PathKind kind);

/// Reads one. Diagnostics: all that is wrong with its form.
[[nodiscard]] MotionTask read_motion(PathKind kind, const OperationSource& source);

/// The operations ptp, lin, circ, spline and move.
[[nodiscard]] Operation ptp_operation();
[[nodiscard]] Operation lin_operation();
[[nodiscard]] Operation circ_operation();
[[nodiscard]] Operation spline_operation();
[[nodiscard]] Operation move_operation();
/// Several of them, blended into one motion, as a command of a transaction.
[[nodiscard]] Operation motions_operation();

}  // namespace takt::operations
