#include "core/kinematics/lines.h"

#include <algorithm>

namespace takt::kinematics {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Angle2 onto_plane(const Vector3d& axis, const Vector3d& p, const Vector3d& h, double d) {
  const double c = h.dot(axis) * axis.dot(p);
  const double a = h.dot(p) - c;
  const double b = h.dot(axis.cross(p));
  const double radius = std::hypot(a, b);
  if (radius < 1e-12) return std::abs(d - c) < 1e-9 ? Angle2{{0.0, 0.0}, 1} : Angle2{};
  const double ratio = (d - c) / radius;
  if (std::abs(ratio) > 1.0 + 1e-9) return {};
  const double middle = std::atan2(b, a);
  const double half = std::acos(std::clamp(ratio, -1.0, 1.0));
  return {{middle + half, middle - half}, half == 0.0 ? 1 : 2};
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
  ThreeTurns result;
  // c turns with the first two only, and its angle to a with the second only.
  const Vector3d goal = R * c;
  const Vector3d across = c.unitOrthogonal();
  for (const double y : onto_plane(b, c, a, a.dot(goal))) {
    const Matrix3d second = turn(b, y);
    const double x = onto_point(a, second * c, goal);
    const Vector3d rest = second.transpose() * (turn(a, -x) * (R * across));
    result.angles[static_cast<std::size_t>(result.count++)] = {x, y, onto_point(c, across, rest)};
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
