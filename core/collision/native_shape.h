#pragma once

#include <memory>
#include <span>

#include <Eigen/Core>

namespace fcl {
template <class Scalar>
class CollisionGeometry;
}

/// Shapes as FCL knows them: what the narrow phase computes with. Realtime: setup.
namespace takt::collision {

using NativeShape = fcl::CollisionGeometry<double>;
using NativeShapePtr = std::shared_ptr<const NativeShape>;

/// @param half  half of its edges, m
[[nodiscard]] NativeShapePtr native_box(const Eigen::Vector3d& half);
/// Cylinders and capsules lie along z; all lengths in m.
[[nodiscard]] NativeShapePtr native_cylinder(double radius, double half_length);
[[nodiscard]] NativeShapePtr native_capsule(double radius, double half_length);
[[nodiscard]] NativeShapePtr native_sphere(double radius);
/// @param triangles  three indices into the corners each, counter-clockwise seen from outside
[[nodiscard]] NativeShapePtr native_hull(std::span<const Eigen::Vector3d> corners, std::span<const int> triangles);

}  // namespace takt::collision
