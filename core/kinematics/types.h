#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace takt::kinematics {

/// Most movable joints of one chain. A fixed capacity keeps the cycle free of allocation; longer chains are refused at
/// load. Twelve: a seven-axis arm on a planar base (3) on a lift (1), and one to spare.
inline constexpr int kMaxJoints = 12;

/// One number per joint in the order of the chain; rad or m and their derivatives, Nm or N. Never allocates.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxJoints, 1>;
/// Joint-space matrix (n x n). Never allocates.
using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints, kMaxJoints>;
/// Geometric Jacobian (6 x n), linear rows first. Never allocates.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxJoints>;
/// Twist, spatial acceleration or wrench flattened, linear first.
using Vector6 = Eigen::Matrix<double, 6, 1>;

}  // namespace takt::kinematics
