#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/expression/condition_state.h"
#include "core/motion/leg.h"
#include "core/operations/compliance.h"
#include "core/operations/goal.h"
#include "core/operations/operation.h"
#include "core/operations/overlay.h"

namespace takt::activity {

enum class PathKind { kPtp, kLin, kCirc, kSpline };

/// What a motion step says, in numbers. Keys: docs/scenarios.md.
struct MotionRequest {
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
  std::optional<ComplianceParameters> compliance;
  OverlayRequest overlay;
  std::optional<command::StateSource> until;
  bool must_touch = true;                      ///< a guarded motion that reaches its end is a failure
  std::optional<command::StateSource> unless;  ///< as soon as it holds the motion brakes on its path and has failed
  std::string name = {}, pointer = {};
};

/// The arms that motions move, as one name.
[[nodiscard]] std::string moved_by(const MotionRequest& request);

[[nodiscard]] const ParameterTable<MotionRequest>& motion_parameters(PathKind kind);

/// Reads one. Diagnostics: all that is wrong with its form.
[[nodiscard]] MotionRequest read_motion(PathKind kind, const OperationSource& source);

/// The operations ptp, lin, circ and spline.
[[nodiscard]] Operation ptp_operation();
[[nodiscard]] Operation lin_operation();
[[nodiscard]] Operation circ_operation();
[[nodiscard]] Operation spline_operation();
/// Several of them, blended into one motion, as a command of a transaction.
[[nodiscard]] Operation motions_operation();

}  // namespace takt::activity
