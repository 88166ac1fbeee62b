#include "core/world/shape.h"

#include <algorithm>
#include <cmath>

namespace takt::world {
namespace {

double distance_to(const Box& box, const Eigen::Vector3d& p) {
  const Eigen::Vector3d d = p.cwiseAbs() - 0.5 * box.size;
  return d.cwiseMax(0.0).norm() + std::min(d.maxCoeff(), 0.0);
}

double distance_to(const Cylinder& cylinder, const Eigen::Vector3d& p) {
  const Eigen::Vector2d d(std::hypot(p.x(), p.y()) - cylinder.radius, std::abs(p.z()) - 0.5 * cylinder.length);
  return d.cwiseMax(0.0).norm() + std::min(d.maxCoeff(), 0.0);
}

double distance_to(const Sphere& sphere, const Eigen::Vector3d& p) { return p.norm() - sphere.radius; }

double distance_to(const Capsule& capsule, const Eigen::Vector3d& p) {
  const double half = 0.5 * capsule.length;
  return (p - Eigen::Vector3d(0, 0, std::clamp(p.z(), -half, half))).norm() - capsule.radius;
}

}  // namespace

double signed_distance(const Shape& shape, const Eigen::Vector3d& point) {
  return std::visit([&](const auto& s) { return distance_to(s, point); }, shape);
}

}  // namespace takt::world
