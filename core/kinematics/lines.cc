#include "core/kinematics/lines.h"

#include <algorithm>
#include <numbers>

#include "core/kinematics/cone.h"

namespace takt::kinematics {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// The turned p has the component c + radius cos(angle - middle) along h.
struct Wave {
  double c, radius, middle;
};

Angle2 beside(const Wave& wave, double half) { return {{wave.middle + half, wave.middle - half}, half == 0.0 ? 1 : 2}; }

Angle2 onto_plane(const Wave& wave, double d, double margin) {
  const double off = std::abs(d - wave.c), excess = off / wave.radius - 1.0;
  // A p on the axis goes nowhere. Nearly on it, it is where another geometry would have it on the axis: any angle is a
  // guess.
  if (wave.radius < 1e-12 && off < kExact) return {{0.0, 0.0}, 1};
  const bool on_axis = margin > kExact && wave.radius < margin && off < margin;
  if (on_axis && !(excess <= margin)) return beside(wave, 0.5 * std::numbers::pi);
  if (!(excess <= margin) || wave.radius < 1e-12) return {};
  const double ratio = (d - wave.c) / wave.radius;
  if (excess <= kExact) return beside(wave, std::acos(std::clamp(ratio, -1.0, 1.0)));
  // As far beyond the nearest place as it would be before it, were there as much to spare as is missing.
  const double guess = std::sqrt(2.0 * excess);
  return beside(wave, ratio > 0.0 ? guess : std::numbers::pi - guess);
}

Wave wave_of(const Vector3d& axis, const Vector3d& p, const Vector3d& h) {
  const double c = h.dot(axis) * axis.dot(p);
  const double a = h.dot(p) - c;
  const double b = h.dot(axis.cross(p));
  return {c, std::hypot(a, b), std::atan2(b, a)};
}

}  // namespace

double onto_point_exactly(const Vector3d& axis, const Vector3d& p, const Vector3d& q) {
  const double sine = q.dot(axis.cross(p)), cosine = q.dot(p) - axis.dot(q) * axis.dot(p);
  constexpr double kBeside = 1e-12;  // square of the product of two sines
  const bool beside_axis = sine * sine + cosine * cosine < kBeside * p.squaredNorm() * q.squaredNorm();
  if (!beside_axis) return std::atan2(sine, cosine);
  const Vector3d from = axis.cross(p), to = axis.cross(q);
  return std::atan2(axis.dot(from.cross(to)), from.dot(to));
}

Angle2 onto_plane(const Vector3d& axis, const Vector3d& p, const Vector3d& h, double d) {
  return onto_plane(wave_of(axis, p, h), d, kExact);
}

Angle2 onto_plane(const Vector3d& axis, const Vector3d& p, const Vector3d& h, double d, double margin) {
  return onto_plane(wave_of(axis, p, h), d, margin);
}

Angle2 onto_sphere(const Vector3d& axis, const Vector3d& p, const Vector3d& q, double distance, double margin) {
  return onto_plane(axis, p, q, 0.5 * (p.squaredNorm() + q.squaredNorm() - distance * distance), margin);
}

Angle2 onto_cone(const Vector3d& axis, const Vector3d& p, const Vector3d& h, const Slant& wanted, double margin) {
  const Wave wave = wave_of(axis, p, h);
  constexpr double kEnough = 1e-6;  // of 1 - |ratio|: what the arc cosine then loses is below 1e-13
  const double ratio = wave.radius < 1e-12 ? 0.0 : (wanted.along - wave.c) / wave.radius;
  if (!(std::abs(std::abs(ratio) - 1.0) < kEnough)) return onto_plane(wave, wanted.along, margin);
  // 1 - ratio as the difference of two lengths less their components, each a square over a sum: r - d = across^2 /
  // (r + d). The nearest that p comes to h lies in the plane of axis and h; so does the farthest.
  const double side = ratio > 0.0 ? 1.0 : -1.0, r = p.norm();
  const double nearest = wave.c + side * wave.radius;
  const double off = axis.dot(p) * axis.cross(h).norm() - side * axis.cross(p).norm() * axis.dot(h);
  const double lack = wanted.across * wanted.across / (r + side * wanted.along) - off * off / (r + side * nearest);
  const double share = lack / (2.0 * wave.radius);
  if (share < -margin) return {};
  const bool mirrored = share < -kExact;
  const double half = 2.0 * std::asin(std::sqrt(share > 0.0 || mirrored ? std::abs(share) : 0.0));
  return beside(wave, side > 0.0 ? half : std::numbers::pi - half);
}

Matrix3d turn(const Vector3d& axis, double angle) {
  const double s = std::sin(angle);
  const double c = std::cos(angle);
  const Vector3d v = (1.0 - c) * axis;
  Matrix3d R;
  R << c + v.x() * axis.x(), v.x() * axis.y() - s * axis.z(), v.x() * axis.z() + s * axis.y(),
      v.y() * axis.x() + s * axis.z(), c + v.y() * axis.y(), v.y() * axis.z() - s * axis.x(),
      v.z() * axis.x() - s * axis.y(), v.z() * axis.y() + s * axis.x(), c + v.z() * axis.z();
  return R;
}

ThreeTurns three_turns(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Matrix3d& R) {
  return three_turns(a, b, c, R, kExact);
}

ThreeTurns three_turns(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Matrix3d& R, double margin) {
  ThreeTurns result;
  // c turns with the first two only, and its angle to a with the second only.
  const Vector3d goal = R * c;
  const Vector3d across = c.unitOrthogonal();
  for (const double y : onto_cone(b, c, a, slant(goal, a), margin)) {
    const Matrix3d second = turn(b, y);
    const double x = onto_point_exactly(a, second * c, goal);
    const Vector3d rest = second.transpose() * (turn(a, -x) * (R * across));
    result.angles[static_cast<std::size_t>(result.count++)] = {x, y, onto_point_exactly(c, across, rest)};
  }
  return result;
}

std::optional<Vector3d> meeting(const Line& a, const Line& b) {
  const Vector3d normal = a.axis.cross(b.axis);
  const double square = normal.squaredNorm();
  if (square < kAlmost * kAlmost) return std::nullopt;
  const Vector3d between = b.point - a.point;
  if (std::abs(between.dot(normal)) > kAlmost * std::sqrt(square)) return std::nullopt;
  return a.point + a.axis * (between.cross(b.axis).dot(normal) / square);
}

std::optional<Vector3d> common_point(const Line& a, const Line& b, const Line& c) {
  const auto point = meeting(b, c);
  if (!point || !lies_on(*point, a) || parallel(a.axis, b.axis)) return std::nullopt;
  return point;
}

std::array<Line, kMaxJoints> joint_lines(const Chain& chain, const JointVector& q, Eigen::Isometry3d* X_BF) {
  std::array<Line, kMaxJoints> lines;
  Eigen::Isometry3d X;
  Jacobian J;
  chain.jacobian(q, X, J);
  for (int i = 0; i < chain.joint_count(); ++i) {
    Line& line = lines[static_cast<std::size_t>(i)];
    if (chain.is_prismatic(i)) {
      line = {X.translation(), J.col(i).head<3>()};
      continue;
    }
    line.axis = J.col(i).tail<3>();
    // v = w x (p_F - p): the point of the axis that is nearest to F.
    line.point = X.translation() + line.axis.cross(Vector3d(J.col(i).head<3>()));
  }
  if (X_BF != nullptr) *X_BF = X;
  return lines;
}

}  // namespace takt::kinematics
