#include "core/motion/rotation_vector.h"

#include <cmath>

namespace takt::motion {
namespace {

using Eigen::Vector3d;

/// Below this square of the angle the closed forms lose digits and their series have all.
constexpr double kSmall = 0.01;

/// a = (1 - cos t) / t^2 and b = (t - sin t) / t^3 for t = |phi|, and their derivatives by z = t^2.
struct Coefficients {
  double a, b, da, db;
};

Coefficients coefficients(double z) {
  if (z < kSmall) {
    return {.a = 1.0 / 2 - z * (1.0 / 24 - z * (1.0 / 720 - z / 40320)),
            .b = 1.0 / 6 - z * (1.0 / 120 - z * (1.0 / 5040 - z / 362880)),
            .da = -1.0 / 24 + z * (1.0 / 360 - z * (1.0 / 13440 - z / 907200)),
            .db = -1.0 / 120 + z * (1.0 / 2520 - z * (1.0 / 120960 - z / 9979200))};
  }
  const double t = std::sqrt(z);
  const double sine = std::sin(t);
  const double cosine = std::cos(t);
  return {.a = (1.0 - cosine) / z,
          .b = (t - sine) / (z * t),
          .da = (t * sine - 2.0 * (1.0 - cosine)) / (2.0 * z * z),
          .db = (3.0 * sine - t * (2.0 + cosine)) / (2.0 * z * z * t)};
}

/// The part of the angular acceleration that does not hang on ddphi.
Vector3d bias(const Coefficients& c, const Vector3d& phi, const Vector3d& dphi) {
  const Vector3d cross = phi.cross(dphi);
  const double dz = 2.0 * phi.dot(dphi);
  return c.da * dz * cross + c.db * dz * phi.cross(cross) + c.b * dphi.cross(cross);
}

/// Inverse of the left Jacobian at phi, applied to v.
Vector3d unturned(const Vector3d& phi, const Vector3d& v) {
  const double z = phi.squaredNorm();
  const double t = std::sqrt(z);
  const double c = z < kSmall ? 1.0 / 12 + z * (1.0 / 720 + z * (1.0 / 30240 + z / 1209600))
                              : (1.0 - 0.5 * t / std::tan(0.5 * t)) / z;
  const Vector3d cross = phi.cross(v);
  return v - 0.5 * cross + c * phi.cross(cross);
}

}  // namespace

Eigen::Matrix3d exp_rotation(const Vector3d& phi) {
  const double angle = phi.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

Vector3d log_rotation(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond turn(R);
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  if (sine < 1e-300) return Vector3d::Zero();
  return turn.vec() * (2.0 * std::atan2(sine, turn.w()) / sine);
}

AngularMotion angular_motion(const RotationVector& v) {
  const Coefficients c = coefficients(v.phi.squaredNorm());
  const auto turned = [&](const Vector3d& x) -> Vector3d {
    const Vector3d cross = v.phi.cross(x);
    return x + c.a * cross + c.b * v.phi.cross(cross);
  };
  return {.w = turned(v.dphi), .alpha = turned(v.ddphi) + bias(c, v.phi, v.dphi)};
}

RotationVector rotation_vector(const Vector3d& phi, const AngularMotion& motion) {
  RotationVector v{.phi = phi, .dphi = unturned(phi, motion.w), .ddphi = {}};
  v.ddphi = unturned(phi, motion.alpha - bias(coefficients(phi.squaredNorm()), phi, v.dphi));
  return v;
}

}  // namespace takt::motion
