#pragma once

#include "core/kinematics/chain.h"
#include "core/kinematics/types.h"

namespace takt::motion {

using kinematics::JointVector;

/// What the joints of an arm may do: one entry per joint in the order of the chain, rad or m and their derivatives.
/// `lower` and `upper` may be infinite (continuous joints); the other three are > 0 and finite.
struct JointLimits {
  JointVector lower;
  JointVector upper;
  JointVector velocity;      ///< rad/s or m/s
  JointVector acceleration;  ///< rad/s^2 or m/s^2
  JointVector jerk;          ///< rad/s^3 or m/s^3
  /// The joints are x, y and yaw of a base whose wheels do not move sideways: it drives along its own x axis only,
  /// forward or backward, and turns (a nonholonomic constraint).
  bool nonholonomic = false;
};

/// How fast such a base would go sideways, m/s, to its left: `dq` seen along its own y axis. Realtime: cyclic.
[[nodiscard]] double sideways_speed(double yaw, const JointVector& dq);

/// Longest time (s) that a joint may need to rest, from any state that the limits allow: v/a, and what it takes to turn
/// an acceleration that is the wrong way. Realtime: cyclic.
[[nodiscard]] double longest_stop(const JointLimits& limits);

/// What the frame that moves on a Cartesian path may do (norms of the linear and of the angular vector), all > 0.
struct CartesianLimits {
  double linear_velocity = 1.5;        ///< m/s
  double linear_acceleration = 5.0;    ///< m/s^2
  double linear_jerk = 50.0;           ///< m/s^3
  double angular_velocity = 3.0;       ///< rad/s
  double angular_acceleration = 15.0;  ///< rad/s^2
  double angular_jerk = 150.0;         ///< rad/s^3
};

/// What the motors of an arm have to move beside the links of its chain. Torque limits, damping and friction are the
/// chain's.
struct DriveLoad {
  JointVector armature;  ///< rotors seen at the joints, kg m^2 (kg); size 0: none
  Eigen::Vector3d gravity_B = Eigen::Vector3d(0.0, 0.0, -9.81);  ///< m/s^2
  kinematics::Payload payload = {};
};

}  // namespace takt::motion
