#pragma once

#include <string>

#include <Eigen/Geometry>

#include "core/kinematics/chain.h"

namespace takt::motion {

/// Why no posture puts the flange of an arm at a pose, for people: too far or too near, with the nearest point that the
/// flange gets to in this orientation, or only with another orientation. `X_BF` is out of reach.
/// Realtime: setup, up to 100 searches for one solution.
[[nodiscard]] std::string reach_text(const kinematics::Chain& chain, const Eigen::Isometry3d& X_BF,
                                     const kinematics::JointVector& q_near);

}  // namespace takt::motion
