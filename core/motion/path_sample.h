#pragma once

#include <Eigen/Geometry>

#include "core/kinematics/types.h"
#include "core/motion/path_point.h"

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

}  // namespace takt::motion
