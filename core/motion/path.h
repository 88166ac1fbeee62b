#pragma once

#include <string>
#include <variant>

#include <nlohmann/json_fwd.hpp>

#include "core/base/findings.h"
#include "core/kinematics/types.h"
#include "core/motion/path_clock.h"

namespace takt::motion {

using kinematics::JointVector;
using kinematics::Vector6;

/// A configuration in motion: rad or m, and its first and second derivative by real time.
struct JointSample {
  JointVector q;
  JointVector dq;
  JointVector ddq;
};

/// A frame M in motion, all expressed in base B.
struct FrameSample {
  Eigen::Isometry3d X_BM = Eigen::Isometry3d::Identity();
  Vector6 V_BM_B = Vector6::Zero();  ///< velocity of M's origin, m/s, then angular velocity, rad/s
  Vector6 A_BM_B = Vector6::Zero();  ///< acceleration of M's origin, m/s^2, then angular acceleration, rad/s^2
};

/// All joints in proportion from start to goal (PTP).
/// As JSON: {"kind": "joint_line", "start": [...], "goal": [...]}.
struct JointLine {
  JointVector q_start;
  JointVector q_goal;

  /// Exactly q_goal at s = 1. Realtime: cyclic, no allocation.
  [[nodiscard]] JointSample sample(const PathPoint& at) const;
};

/// The origin of a frame M on a straight line while M turns about one axis that is fixed in B (LIN). Joints that the
/// frame leaves free (redundancy) are *held*: they go in proportion too, in the order of the arm's inverse kinematics.
/// As JSON: {"kind": "cartesian_line", "start": [x, y, z, qw, qx, qy, qz], "direction": [x, y, z], "length_m": m,
/// "axis": [x, y, z], "angle_rad": rad, "held_start": [...], "held_goal": [...]}.
struct CartesianLine {
  Eigen::Vector3d p_start = Eigen::Vector3d::Zero();  ///< origin of M in B, m
  Eigen::Quaterniond R_start = Eigen::Quaterniond::Identity();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit vector in B; UnitX without translation
  double length = 0.0;                                   ///< m, >= 0
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();       ///< unit vector in B; UnitZ without rotation
  double angle = 0.0;                                    ///< rad, in [0, pi] (up to rounding)
  JointVector held_start;
  JointVector held_goal;

  /// The line between two poses, turning the short way. At half a turn both ways are equally long: the axis then has a
  /// positive first component (the first that is not zero). `held_start` and `held_goal` are of one size.
  [[nodiscard]] static CartesianLine between(const Eigen::Isometry3d& X_BM_start, const Eigen::Isometry3d& X_BM_goal,
                                             const JointVector& held_start = {}, const JointVector& held_goal = {});

  /// Realtime: cyclic, no allocation.
  [[nodiscard]] FrameSample sample(const PathPoint& at) const;
  [[nodiscard]] JointSample held(const PathPoint& at) const;
};

/// Geometry over s in [0, 1]. Circles and splines (issue of the motion page) become further alternatives.
using Path = std::variant<JointLine, CartesianLine>;

[[nodiscard]] nlohmann::ordered_json to_json(const Path& path);
/// Findings: unknown kind with the known ones, sizes that differ, entries not finite, vectors not of unit length.
[[nodiscard]] Result<Path> path_from_json(const nlohmann::ordered_json& json, const std::string& pointer = {});

}  // namespace takt::motion
