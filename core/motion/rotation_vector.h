#pragma once

#include <Eigen/Geometry>

namespace takt::motion {

/// A turn that changes: rotation vector phi of R = exp(phi) R_ref, and its first and second derivative; rad.
struct RotationVector {
  Eigen::Vector3d phi = Eigen::Vector3d::Zero();
  Eigen::Vector3d dphi = Eigen::Vector3d::Zero();
  Eigen::Vector3d ddphi = Eigen::Vector3d::Zero();
};

/// Angular velocity and acceleration of R, in the axes of the frame that R maps into.
struct AngularMotion {
  Eigen::Vector3d w = Eigen::Vector3d::Zero();      ///< rad per unit of the parameter
  Eigen::Vector3d alpha = Eigen::Vector3d::Zero();  ///< its derivative
};

/// Rotation by |phi| about phi. Realtime: cyclic.
[[nodiscard]] Eigen::Matrix3d exp_rotation(const Eigen::Vector3d& phi);
/// The rotation vector of R, at most pi long. Realtime: cyclic.
[[nodiscard]] Eigen::Vector3d log_rotation(const Eigen::Matrix3d& R);

/// Through the left Jacobian of the exponential map: w = J(phi) dphi. Realtime: cyclic.
/// Source: Bullo, Murray, "Proportional derivative control on the Euclidean group", 1995, appendix; derivative: own.
[[nodiscard]] AngularMotion angular_motion(const RotationVector& v);
/// The other way round, for |phi| < pi: the rotation vector whose motion is the given one. Realtime: cyclic.
[[nodiscard]] RotationVector rotation_vector(const Eigen::Vector3d& phi, const AngularMotion& motion);

}  // namespace takt::motion
