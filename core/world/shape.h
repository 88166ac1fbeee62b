#pragma once

#include <string>
#include <variant>
#include <vector>

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

/// A physical object as the application knows it: one or several shapes fixed to its frame O.
struct Object {
  struct Part {
    Shape shape;
    Eigen::Isometry3d X_OS = Eigen::Isometry3d::Identity();
  };
  std::string name;
  std::vector<Part> parts;
};

/// Signed distance to the union of the parts (exact outside), m. The point is in object frame O.
[[nodiscard]] double signed_distance(const Object& object, const Eigen::Vector3d& p_O);

}  // namespace takt::world
