#pragma once

#include <Eigen/Geometry>

namespace takt::kinematics {

struct Angle2;  // lines.h

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
                               const Slant& wanted);

}  // namespace takt::kinematics
