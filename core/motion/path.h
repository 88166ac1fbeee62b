#pragma once

#include <string>
#include <variant>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/motion/path_curve.h"
#include "core/motion/path_sample.h"

namespace takt::motion {

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

/// A line of a frame M in the room, as an arm sees it whose own base A is carried along meanwhile: by a carrier that
/// drives in the plane, x, y and yaw in proportion. What the arm on a mobile base follows so that its tool goes
/// straight. Samples are of M in A; held joints are those of the line.
/// As JSON: {"kind": "carried_line", "line": a cartesian_line in B, "carrier_start": [x, y, yaw], "carrier_goal":
/// [x, y, yaw], "mount": [x, y, z, qw, qx, qy, qz]}.
struct CarriedLine {
  CartesianLine line;                                       ///< in the frame B in which the carrier moves
  Eigen::Vector3d carrier_start = Eigen::Vector3d::Zero();  ///< x, y in m, yaw in rad, of the carrier's body F in B
  Eigen::Vector3d carrier_goal = Eigen::Vector3d::Zero();   ///< likewise
  Eigen::Isometry3d X_FA = Eigen::Isometry3d::Identity();   ///< the arm's base on the carrier's body, m

  /// Realtime: cyclic, no allocation.
  [[nodiscard]] FrameSample sample(const PathPoint& at) const;
  [[nodiscard]] JointSample held(const PathPoint& at) const { return line.held(at); }
};

/// The origin of a frame M on a circle while M turns about one axis that is fixed in B (CIRC); held joints as in
/// CartesianLine. As JSON: {"kind": "cartesian_arc", "start": [x, y, z, qw, qx, qy, qz], "centre": [x, y, z],
/// "normal": [x, y, z], "arc_rad": rad, "axis": [x, y, z], "angle_rad": rad, "held_start": [...], "held_goal": [...]}.
struct CartesianArc {
  Eigen::Vector3d p_start = Eigen::Vector3d::Zero();  ///< origin of M in B, m
  Eigen::Quaterniond R_start = Eigen::Quaterniond::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< in B, m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit vector in B, at right angles to p_start - centre
  double arc = 0.0;                                   ///< rad about the normal, >= 0
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();    ///< of the turn of M: unit vector in B
  double angle = 0.0;                                 ///< of the turn of M, rad, >= 0
  JointVector held_start;
  JointVector held_goal;

  /// Realtime: cyclic, no allocation.
  [[nodiscard]] FrameSample sample(const PathPoint& at) const;
  [[nodiscard]] JointSample held(const PathPoint& at) const;
};

/// A turn about one fixed axis that takes R_start to R_goal the short way; at half a turn the axis is made unique.
struct FixedAxisTurn {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double angle = 0.0;  ///< rad, in [0, pi] (up to rounding)
};
[[nodiscard]] FixedAxisTurn short_turn(const Eigen::Quaterniond& R_start, const Eigen::Quaterniond& R_goal);

/// What a piece of a path may be: geometry over a parameter of its own in [0, 1].
using Geometry = std::variant<JointLine, CartesianLine, CartesianArc, JointCurve, CartesianCurve, CarriedLine>;

/// One point of any path: joints on a joint path, a frame and held joints on a Cartesian one.
struct PathSample {
  bool cartesian = false;
  JointSample joints;
  FrameSample frame;
  JointSample held;
};

[[nodiscard]] bool is_cartesian(const Geometry& geometry);
/// Realtime: cyclic, no allocation.
[[nodiscard]] PathSample sample(const Geometry& geometry, const PathPoint& at);

/// The part [own_begin, own_end] of a geometry, over [s_begin, s_end] of the path that it belongs to.
struct PathPiece {
  Geometry geometry;
  double s_begin = 0.0;
  double s_end = 1.0;
  double own_begin = 0.0;
  double own_end = 1.0;

  /// Where s lies in the geometry, with the derivatives of the geometry's own parameter. Realtime: cyclic.
  [[nodiscard]] PathPoint own(const PathPoint& at) const;
};

/// Pieces one after the other, joined smoothly by whoever planned them (docs/motion.md).
/// As JSON: {"kind": "composite", "pieces": [{"s": [begin, end], "own": [begin, end], "geometry": {"kind": ...}},
/// ...]}.
struct CompositePath {
  std::vector<PathPiece> pieces;  ///< at least one; from s = 0 to s = 1 without gaps

  /// The piece that s lies in; where two meet, the later one. Realtime: cyclic, O(log pieces).
  [[nodiscard]] std::size_t piece_at(double s) const;
  /// Realtime: cyclic, no allocation.
  [[nodiscard]] PathSample sample(const PathPoint& at) const;
  [[nodiscard]] bool has_joint_pieces() const;
  [[nodiscard]] bool has_cartesian_pieces() const;
};

/// Geometry over s in [0, 1].
using Path = std::variant<JointLine, CartesianLine, CartesianArc, CompositePath>;

/// Realtime: cyclic, no allocation.
[[nodiscard]] PathSample sample(const Path& path, const PathPoint& at);

/// The pieces of any path; one of a path that is none composite. Realtime: setup.
[[nodiscard]] std::vector<PathPiece> pieces_of(const Path& path);

[[nodiscard]] nlohmann::ordered_json to_json(const Path& path);
/// Diagnostics: unknown kind with the known ones, sizes that differ, entries not finite, vectors not of unit length,
/// pieces that leave a gap in s or do not meet in space.
[[nodiscard]] Result<Path> path_from_json(const nlohmann::ordered_json& json, const std::string& pointer = {});

}  // namespace takt::motion
