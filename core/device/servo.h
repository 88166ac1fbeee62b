#pragma once

#include "core/device/description.h"

namespace takt::device {

/// How an arm answers at its tool, along one direction, to its set point and to a force: like a mass on a spring and a
/// damper, to whose other ends the set point belongs. All other directions are free.
struct ServoResponse {
  double stiffness = 0.0;          ///< force over deflection at rest, N/m; 0: nothing holds the tool there
  double natural_frequency = 0.0;  ///< rad/s
  double damping_ratio = 0.0;

  /// In which it forgets a difference of velocities, s.
  [[nodiscard]] double damping_time() const { return 1.0 / (2.0 * damping_ratio * natural_frequency); }
};

/// An arm where it is, with what it carries.
struct ServoPosture {
  const JointVector& q;                ///< rad or m
  const kinematics::Jacobian& J_BT;    ///< of the tool T's origin, in the axes of the base B, linear rows first
  const Eigen::Matrix3d& R_BT;         ///< axes of T in B
  const kinematics::Payload& payload;  ///< on the flange
};

/// In mode position from the figures of the position loops (`control.gains` of the device file) and the inertia, in a
/// mode of impedance from its springs and dampers.
/// @param compliance   how the arm yields; size 0 in mode position
/// @param direction_B  of length 1
/// Realtime: cyclic, one mass matrix and its factors.
[[nodiscard]] ServoResponse servo_response(const ArmDescription& arm, const Compliance& compliance,
                                           const ServoPosture& posture, const Eigen::Vector3d& direction_B);

/// The same through a tip that gives way by so much, m/N: softer by the spring that is in series, and faster where the
/// tip is softer than the arm, since it yields before the arm's mass matters (docs/force-control.md, "Tips that
/// yield").
[[nodiscard]] ServoResponse through_tip(const ServoResponse& arm, double compliance);

}  // namespace takt::device
