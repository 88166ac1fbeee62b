#pragma once

#include <string>

#include <Eigen/Geometry>

#include "core/kinematics/robot_model.h"

namespace takt::device {

/// Pose of link `to` in link `from`; both belong to one rigid model (or all joints are at zero).
[[nodiscard]] Eigen::Isometry3d pose_between(const kinematics::RobotModel& robot, const std::string& from,
                                             const std::string& to);

}  // namespace takt::device
