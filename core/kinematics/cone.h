#pragma once

#include <Eigen/Geometry>

namespace takt::kinematics {

struct Angle2;      // lines.h
struct ThreeTurns;  // lines.h

/// By how much an arm may differ from the geometry of its closed form, as a share of what p can do: where p fails by
/// less there are two angles on both sides of where it comes nearest, good guesses for Newton's method. kExact:
/// rounding only.
inline constexpr double kExact = 1e-9;

/// onto_point() with all digits also where p and q are nearly on the axis: there differences of products have none
/// left, cross products have. Elsewhere the same bits. Realtime: cyclic, as all below.
[[nodiscard]] double onto_point_exactly(const Eigen::Vector3d& axis, const Eigen::Vector3d& p,
                                        const Eigen::Vector3d& q);

/// The component of a vector along a direction, and the length of the rest: an angle with all its digits, also near 0
/// and pi.
struct Slant {
  double along = 0.0, across = 0.0;
};
[[nodiscard]] inline Slant slant(const Eigen::Vector3d& v, const Eigen::Vector3d& direction) {
  return {v.dot(direction), v.cross(direction).norm()};
}

/// onto_plane() for h of unit length where d = wanted.along is that of a vector as long as p. Where p comes to lie
/// nearly along h, d alone has lost half of the digits of the angle, and `across` has them. Elsewhere the same bits.
[[nodiscard]] Angle2 onto_cone(const Eigen::Vector3d& axis, const Eigen::Vector3d& p, const Eigen::Vector3d& h,
                               const Slant& wanted, double margin);

/// onto_plane(), onto_sphere() and three_turns() with a margin.
[[nodiscard]] Angle2 onto_plane(const Eigen::Vector3d& axis, const Eigen::Vector3d& p, const Eigen::Vector3d& h,
                                double d, double margin);
[[nodiscard]] Angle2 onto_sphere(const Eigen::Vector3d& axis, const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                                 double distance, double margin);
[[nodiscard]] ThreeTurns three_turns(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                     const Eigen::Matrix3d& R, double margin);

}  // namespace takt::kinematics
