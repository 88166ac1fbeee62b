#pragma once

#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "core/kinematics/chain.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// The axis of a joint: a line with a direction. Point in m, direction of unit length.
struct Line {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
};

/// Axes count as meeting or parallel within this, m and rad. Far more than rounding: files write 1.5708 for a right
/// angle, and calibrated arms are a little crooked. What a closed form says of such an arm is a good guess for Newton's
/// method, which always has the last word.
inline constexpr double kAlmost = 1e-3;

/// The angle about `axis` that takes p as near as possible to q. Realtime: cyclic, as all below.
[[nodiscard]] inline double onto_point(const Eigen::Vector3d& axis, const Eigen::Vector3d& p,
                                       const Eigen::Vector3d& q) {
  return std::atan2(q.dot(axis.cross(p)), q.dot(p) - axis.dot(q) * axis.dot(p));
}

/// Up to two angles, rad.
struct Angle2 {
  std::array<double, 2> value{};
  int count = 0;
  [[nodiscard]] const double* begin() const { return value.data(); }
  [[nodiscard]] const double* end() const { return value.data() + count; }
};

/// The angles about `axis` for which the turned p has the component d along h. None if it never has; the margin keeps
/// touching cases, which rounding could lose.
[[nodiscard]] Angle2 onto_plane(const Eigen::Vector3d& axis, const Eigen::Vector3d& p, const Eigen::Vector3d& h,
                                double d);

/// The angles about `axis` for which the turned p lies at `distance` from q.
[[nodiscard]] inline Angle2 onto_sphere(const Eigen::Vector3d& axis, const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                                        double distance) {
  return onto_plane(axis, p, q, 0.5 * (p.squaredNorm() + q.squaredNorm() - distance * distance));
}

/// Rotation about an axis of unit length. Source: Rodrigues.
[[nodiscard]] Eigen::Matrix3d turn(const Eigen::Vector3d& axis, double angle);

/// Angles with turn(a, x) turn(b, y) turn(c, z) = R; up to two triples. Where a and the turned c are in line only the
/// sum of x and z is determined, and x is zero. None if the axes cannot make R.
struct ThreeTurns {
  std::array<std::array<double, 3>, 2> angles{};
  int count = 0;
};
[[nodiscard]] ThreeTurns three_turns(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                     const Eigen::Matrix3d& R);

[[nodiscard]] inline bool parallel(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return a.cross(b).squaredNorm() < kAlmost * kAlmost;
}

/// Where two lines meet, if they do in one point.
[[nodiscard]] std::optional<Eigen::Vector3d> meeting(const Line& a, const Line& b);

[[nodiscard]] inline bool lies_on(const Eigen::Vector3d& p, const Line& line) {
  return (p - line.point).cross(line.axis).squaredNorm() < kAlmost * kAlmost;
}

/// The point of the line that is nearest to p.
[[nodiscard]] inline Eigen::Vector3d foot(const Eigen::Vector3d& p, const Line& line) {
  return line.point + line.axis * line.axis.dot(p - line.point);
}

/// Where the last three of these axes meet in one point, no two neighbours in line: a spherical wrist (or, from the
/// other end, a spherical shoulder).
[[nodiscard]] std::optional<Eigen::Vector3d> common_point(const Line& a, const Line& b, const Line& c);

/// The axes of a chain at q in frame B; a sliding joint's line has its direction and some point. Entries beyond the
/// last joint are unspecified.
[[nodiscard]] std::array<Line, kMaxJoints> joint_lines(const Chain& chain, const JointVector& q,
                                                       Eigen::Isometry3d* X_BF = nullptr);

}  // namespace takt::kinematics
