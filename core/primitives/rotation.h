#pragma once

#include <cmath>

#include "core/net/value.h"

namespace takt::primitives {

/// The rotation vector (axis times angle in [0, pi], rad) of a unit quaternion. Realtime: cyclic.
inline net::Vector rotation_log(const net::Rotation& R) {
  const double sine = R.vec().norm();
  const double w = R.w();
  if (sine == 0.0) return net::Vector::Zero();
  const double half = w < 0.0 ? std::atan2(-sine, -w) : std::atan2(sine, w);
  return (2.0 * half / sine) * R.vec();
}

/// The unit quaternion (w >= 0 up to angles of pi) of a rotation vector (rad).
inline net::Rotation rotation_exp(const net::Vector& v) {
  const double angle = v.norm();
  // sin(x/2)/x by its series where the quotient would lose digits.
  const double share = angle > 1e-4 ? std::sin(0.5 * angle) / angle : 0.5 - angle * angle / 48.0;
  return net::Rotation(std::cos(0.5 * angle), share * v.x(), share * v.y(), share * v.z()).normalized();
}

/// On the shortest way from a to b: a at 0, b at 1.
inline net::Rotation rotation_between(const net::Rotation& a, const net::Rotation& b, double share) {
  return (a * rotation_exp(share * rotation_log(a.conjugate() * b))).normalized();
}

/// The quaternion of the axes of a frame, w >= 0.
inline net::Rotation rotation_of(const net::Frame& X) {
  net::Rotation R(X.linear());
  R.normalize();
  if (R.w() < 0.0) R.coeffs() = -R.coeffs();
  return R;
}

inline net::Frame make_frame(const net::Rotation& R, const net::Vector& p) {
  net::Frame X = net::Frame::Identity();
  X.linear() = R.toRotationMatrix();
  X.translation() = p;
  return X;
}

}  // namespace takt::primitives
