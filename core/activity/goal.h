#pragma once

#include <string>
#include <variant>

#include <nlohmann/json_fwd.hpp>

#include "core/base/object_reader.h"
#include "core/command/cell.h"

namespace takt::activity {

/// Where a motion goes.
///   "home"                                                 the posture of the model's device file
///   {"joints_deg": [...]}                                  joint positions
///   {"in": FRAME, "position_m": [...], "rpy_deg": [...]}    tool centre point in a frame; without orientation it is
///   kept
///   {"by_m": [...], "in": FRAME, "by_rpy_deg": [...]}       step from the present set point, along the axes of a frame
///                                                          ("tcp": of the tool); turned about the tool's own axes
struct Goal {
  struct Home {};
  struct Joints {
    kinematics::JointVector q;
  };
  struct Pose {
    std::string in;
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    bool keep_orientation = false;
  };
  struct Step {
    std::string in;
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  };
  std::variant<Home, Joints, Pose, Step> value;
};

/// Reads key "to" of a motion step of `arm`; findings in the reader.
[[nodiscard]] Goal read_goal(ObjectReader& reader, const command::MountedArm* arm);

/// A goal in numbers: joint positions, or the pose of the tool centre point T in the arm's base B.
using ResolvedGoal = std::variant<kinematics::JointVector, Eigen::Isometry3d>;

/// @param q  where the arm's set point is. @return findings for an unknown frame. Realtime: setup.
[[nodiscard]] Result<ResolvedGoal> resolve(const Goal& goal, const command::Cell& cell, const std::string& arm,
                                           const kinematics::JointVector& q);

/// Pose of the tool centre point of an arm in its base at q.
[[nodiscard]] Eigen::Isometry3d tool_pose(const command::MountedArm& arm, const kinematics::JointVector& q);

}  // namespace takt::activity
