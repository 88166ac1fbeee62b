#pragma once

#include <cmath>

#include <Eigen/Geometry>

#include "core/kinematics/types.h"

namespace takt::kinematics {

/// The motion that takes pose X_BA to pose X_BT in B: translation, then rotation vector (axis times angle, up to pi).
/// Zero if and only if the poses are equal; a true first-order step for Newton's method. Realtime: cyclic.
[[nodiscard]] inline Vector6 pose_error(const Eigen::Isometry3d& X_BA, const Eigen::Isometry3d& X_BT) {
  const auto& A = X_BA.matrix();
  const auto& T = X_BT.matrix();
  // The skew part of R = R_BT R_BA' is sin(angle) times the axis: half the sum of the columns' cross products.
  Eigen::Vector3d sine = Eigen::Vector3d::Zero();
  double trace = 0.0;
  for (int k = 0; k < 3; ++k) {
    sine.x() += A(1, k) * T(2, k) - A(2, k) * T(1, k);
    sine.y() += A(2, k) * T(0, k) - A(0, k) * T(2, k);
    sine.z() += A(0, k) * T(1, k) - A(1, k) * T(0, k);
    trace += A(0, k) * T(0, k) + A(1, k) * T(1, k) + A(2, k) * T(2, k);
  }
  sine *= 0.5;
  Vector6 error;
  error.head<3>() = X_BT.translation() - X_BA.translation();
  const double square = sine.squaredNorm();
  const double cosine = 0.5 * (trace - 1.0);
  if (cosine > 0.9) {
    // angle / sin(angle) by its series in sin(angle)^2; the remainder is below 1e-4 here and gone near zero.
    error.tail<3>() = sine * (1.0 + square * (1.0 / 6.0 + square * (3.0 / 40.0 + square * (15.0 / 336.0))));
  } else if (cosine > -0.999) {
    error.tail<3>() = sine * (std::atan2(std::sqrt(square), cosine) / std::sqrt(square));
  } else {
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(X_BT.linear() * X_BA.linear().transpose()));
    error.tail<3>() = turn.angle() * turn.axis();
  }
  return error;
}

}  // namespace takt::kinematics
