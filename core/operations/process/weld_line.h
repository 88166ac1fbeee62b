#pragma once

#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/expression/cell.h"

/// Lines of workpieces as paths of a torch. Realtime: setup.
namespace takt::operations {

/// A point of a line, in the base of an arm.
struct LinePoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m
  Eigen::Vector3d inward = Eigen::Vector3d::UnitZ();   ///< into the joint, length 1
  Eigen::Vector3d along = Eigen::Vector3d::UnitX();    ///< in which the line begins, length 1
  std::optional<Eigen::Vector3d> via = {};             ///< an arc from the point before leads through here
};

/// Where the points of a line are, from the frames WORKPIECE/LINE/1, 2, ... that the cell has for it, and
/// WORKPIECE/LINE/2/via where an arc leads to point 2.
/// @return at least two points; or diagnostics: there is no such line, or it moves against the arm.
[[nodiscard]] Result<std::vector<LinePoint>> line_points(const expression::Cell& cell, const std::string& workpiece,
                                                         const std::string& line, const std::string& arm);

/// How a torch is held along a line. Angles in rad.
struct TorchAngles {
  double stick_out = 0.015;  ///< m, from the tool centre point to the line, along z of the tool
  double travel = 0.0;       ///< positive: it points ahead (push), negative: back (drag)
  double work = 0.0;         ///< to the left of the direction of travel, seen from outside
  double rotation = 0.0;     ///< about its own axis, from where its x is along the beginning of the line
};

/// A pose of the tool at a point of a line, and the direction in which a weave swings there.
struct TorchPose {
  Eigen::Isometry3d X_BT = Eigen::Isometry3d::Identity();
  Eigen::Vector3d across_T = Eigen::Vector3d::UnitY();  ///< of the way that leads here, in the axes of the tool
  std::optional<Eigen::Vector3d> p_via = {};            ///< of the tool centre point on the arc that leads here, in B
};
/// One per point: at a corner in the middle between the two directions. The torch turns about its own axis no more than
/// its tilt requires.
[[nodiscard]] std::vector<TorchPose> torch_poses(const std::vector<LinePoint>& points, const TorchAngles& angles);

}  // namespace takt::operations
