#pragma once

#include <Eigen/Geometry>

#include "languages/urscript/value.h"

namespace takt::languages::urscript {

/// x, y, z in m and a rotation vector in rad, as all interfaces of a controller write poses.
[[nodiscard]] Eigen::Isometry3d to_isometry(const Pose& pose);
[[nodiscard]] Pose to_pose(const Eigen::Isometry3d& X);

}  // namespace takt::languages::urscript
