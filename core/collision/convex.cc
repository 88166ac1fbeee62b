#include "core/collision/convex.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/collision/hull.h"
#include "core/collision/mesh.h"

namespace takt::collision {
namespace {

/// Radius of the disc in a direction across it; zero along the axis, where any point of the disc will do.
Eigen::Vector3d on_disc(const Eigen::Vector3d& direction, double radius) {
  const double across = direction.head<2>().norm();  // std::hypot takes longer than all the rest
  if (across == 0.0) return Eigen::Vector3d::Zero();
  return {direction.x() / across * radius, direction.y() / across * radius, 0.0};
}

double signed_half(double direction, double half) { return direction < 0.0 ? -half : half; }

}  // namespace

Convex Convex::from(const world::Shape& shape) {
  Convex made;
  if (const auto* box = std::get_if<world::Box>(&shape)) {
    made.kind_ = Kind::kBox;
    made.half_ = 0.5 * box->size;
    made.native_ = native_box(made.half_);
  } else if (const auto* cylinder = std::get_if<world::Cylinder>(&shape)) {
    made.kind_ = Kind::kCylinder;
    made.half_ = {cylinder->radius, cylinder->radius, 0.5 * cylinder->length};
    made.native_ = native_cylinder(cylinder->radius, 0.5 * cylinder->length);
  } else if (const auto* capsule = std::get_if<world::Capsule>(&shape)) {
    made.kind_ = Kind::kCapsule;
    made.half_ = {capsule->radius, capsule->radius, 0.5 * capsule->length};
    made.native_ = native_capsule(capsule->radius, 0.5 * capsule->length);
  } else {
    made.kind_ = Kind::kSphere;
    made.half_.setConstant(std::get<world::Sphere>(shape).radius);
    made.native_ = native_sphere(made.half_.x());
  }
  made.enclose();
  return made;
}

Result<Convex> Convex::hull(std::span<const Eigen::Vector3d> points) {
  auto found = convex_hull(points);
  if (!found) return std::unexpected(std::move(found.error()));
  Convex made;
  made.kind_ = Kind::kHull;
  made.hull_ = std::make_shared<const Hull>(Hull{std::move(found->corners), std::move(found->triangles)});
  made.enclose();
  made.native_ = native_hull(made.corners(), made.triangles());
  return made;
}

std::span<const Eigen::Vector3d> Convex::corners() const {
  return hull_ ? std::span<const Eigen::Vector3d>(hull_->corners) : std::span<const Eigen::Vector3d>();
}

std::span<const int> Convex::triangles() const {
  return hull_ ? std::span<const int>(hull_->triangles) : std::span<const int>();
}

Eigen::Vector3d Convex::support(const Eigen::Vector3d& direction) const {
  switch (kind_) {
    case Kind::kBox:
      return {signed_half(direction.x(), half_.x()), signed_half(direction.y(), half_.y()),
              signed_half(direction.z(), half_.z())};
    case Kind::kCylinder: {
      Eigen::Vector3d point = on_disc(direction, half_.x());
      point.z() = signed_half(direction.z(), half_.z());
      return point;
    }
    case Kind::kSphere:
    case Kind::kCapsule: {
      const double norm = direction.norm();
      Eigen::Vector3d point = norm > 0.0 ? Eigen::Vector3d(direction * (half_.x() / norm)) : Eigen::Vector3d::Zero();
      if (kind_ == Kind::kCapsule) point.z() += signed_half(direction.z(), half_.z());
      return point;
    }
    case Kind::kHull:
      break;
  }
  const std::vector<Eigen::Vector3d>& corners = hull_->corners;
  std::size_t best = 0;
  double furthest = corners[0].dot(direction);
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const double along = corners[i].dot(direction);
    if (along <= furthest) continue;
    furthest = along;
    best = i;
  }
  return corners[best];
}

void Convex::enclose() {
  if (kind_ == Kind::kHull) {
    box_.setEmpty();
    for (const Eigen::Vector3d& corner : hull_->corners) box_.extend(corner);
    centre_ = box_.center();
    radius_ = 0.0;
    for (const Eigen::Vector3d& corner : hull_->corners) radius_ = std::max(radius_, (corner - centre_).norm());
    return;
  }
  Eigen::Vector3d extent = half_;
  if (kind_ == Kind::kCapsule) extent.z() += half_.x();
  box_ = Eigen::AlignedBox3d(-extent, extent);
  switch (kind_) {
    case Kind::kBox:
      radius_ = half_.norm();
      break;
    case Kind::kCylinder:
      radius_ = std::hypot(half_.x(), half_.z());
      break;
    default:
      radius_ = extent.maxCoeff();
  }
}

Result<Convex> convex_of(const kinematics::Shape& shape) {
  if (const auto* box = std::get_if<kinematics::Box>(&shape)) return Convex::from(world::Box{box->size});
  if (const auto* cylinder = std::get_if<kinematics::Cylinder>(&shape))
    return Convex::from(world::Cylinder{cylinder->radius, cylinder->length});
  if (const auto* sphere = std::get_if<kinematics::Sphere>(&shape)) return Convex::from(world::Sphere{sphere->radius});
  const auto& mesh = std::get<kinematics::Mesh>(shape);
  auto points = read_mesh_points(mesh.path);
  if (!points) return std::unexpected(std::move(points.error()));
  for (Eigen::Vector3d& point : *points) point = point.cwiseProduct(mesh.scale);
  auto hull = Convex::hull(*points);
  if (!hull)
    return failure(Code::kInvalidValue, "",
                   fmt::format("mesh '{}': {}", mesh.name, hull.error().list().front().message));
  return hull;
}

}  // namespace takt::collision
