#pragma once

#include <variant>

#include <Eigen/Geometry>

namespace takt::world {

// Shapes are centred on their frame; lengths in m; cylinder and capsule along z, `length` without the caps.
struct Box {
  Eigen::Vector3d size = Eigen::Vector3d::Ones();  ///< full edge lengths
};
struct Cylinder {
  double radius = 0.5, length = 1.0;
};
struct Sphere {
  double radius = 0.5;
};
struct Capsule {
  double radius = 0.5, length = 1.0;
};
using Shape = std::variant<Box, Cylinder, Sphere, Capsule>;

/// Signed distance from a point to the surface of a shape, negative inside; exact. Both in the shape's frame, m.
/// Realtime: cyclic.
[[nodiscard]] double signed_distance(const Shape& shape, const Eigen::Vector3d& point);

}  // namespace takt::world
