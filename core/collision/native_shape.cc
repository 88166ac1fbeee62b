#include "core/collision/native_shape.h"

#include <cstddef>
#include <vector>

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>

namespace takt::collision {

NativeShapePtr native_box(const Eigen::Vector3d& half) { return std::make_shared<fcl::Boxd>(2.0 * half); }

NativeShapePtr native_cylinder(double radius, double half_length) {
  return std::make_shared<fcl::Cylinderd>(radius, 2.0 * half_length);
}

NativeShapePtr native_capsule(double radius, double half_length) {
  return std::make_shared<fcl::Capsuled>(radius, 2.0 * half_length);
}

NativeShapePtr native_sphere(double radius) { return std::make_shared<fcl::Sphered>(radius); }

NativeShapePtr native_hull(std::span<const Eigen::Vector3d> corners, std::span<const int> triangles) {
  auto faces = std::make_shared<std::vector<int>>();
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    faces->push_back(3);
    faces->insert(faces->end(), triangles.begin() + static_cast<std::ptrdiff_t>(i),
                  triangles.begin() + static_cast<std::ptrdiff_t>(i + 3));
  }
  return std::make_shared<fcl::Convexd>(
      std::make_shared<const std::vector<Eigen::Vector3d>>(corners.begin(), corners.end()),
      static_cast<int>(triangles.size() / 3), faces);
}

}  // namespace takt::collision
