#include "sim/contact/solid_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace takt::sim {
namespace {

using Eigen::Vector3d;
using world::Revolved;
using world::SurfacePoint;

constexpr double kFarAway = std::numeric_limits<double>::infinity();
constexpr double kParallel = 1.0 - 1e-12;  // cosine between the normals of two faces

SurfacePoint nearest_of_box(const Vector3d& p, const Vector3d& half) {
  const Vector3d over = p.cwiseAbs() - half;
  SurfacePoint surface;
  Eigen::Index axis = 0;
  surface.distance = over.maxCoeff(&axis);
  surface.flat = true;
  surface.normal = Vector3d::Unit(axis) * (p[axis] < 0.0 ? -1.0 : 1.0);
  if (surface.distance <= 0.0) return surface;
  Vector3d out = over.cwiseMax(0.0);
  surface.flat = (out.array() > 0.0).count() == 1;
  surface.edge = !surface.flat;
  surface.distance = out.norm();
  surface.normal = out.cwiseProduct(p.cwiseSign()) / surface.distance;
  return surface;
}

double distance_of_box(const Vector3d& p, const Vector3d& half) {
  const Vector3d over = p.cwiseAbs() - half;
  const double deepest = over.maxCoeff();
  return deepest <= 0.0 ? deepest : over.cwiseMax(0.0).norm();
}

SurfacePoint nearest_of_ball(const Vector3d& p, double radius) {
  const double length = p.norm();
  return {.distance = length - radius, .normal = length > 0.0 ? Vector3d(p / length) : Vector3d::UnitZ()};
}

/// From the nearest point of a capsule's axis.
Vector3d from_axis(const Vector3d& p, double half) { return p - Vector3d(0, 0, std::clamp(p.z(), -half, half)); }

SurfacePoint nearest_of_hull(const Vector3d& p, const MeshHull& hull) {
  SurfacePoint surface{.distance = -kFarAway, .flat = true};
  for (const Eigen::Vector4d& plane : hull.planes) {
    const double distance = plane.head<3>().dot(p) - plane[3];
    if (distance <= surface.distance) continue;
    surface.distance = distance;
    surface.normal = plane.head<3>();
  }
  return surface;
}

double distance_of_hull(const Vector3d& p, const MeshHull& hull) {
  double distance = -kFarAway;
  for (const Eigen::Vector4d& plane : hull.planes) distance = std::max(distance, plane.head<3>().dot(p) - plane[3]);
  return distance;
}

using Disc = NearSurface::Disc;

struct BallRegion {
  Vector3d centre;
  double radius = 0.0;

  /// Where its points are about the z axis of a frame, seen from G.
  [[nodiscard]] Disc about_axis(const Pose& X_FG) const {
    const Vector3d c = X_FG * centre;
    return {{c.head<2>().norm(), c.z()}, radius};
  }
  [[nodiscard]] Disc about_axis() const { return {{centre.head<2>().norm(), centre.z()}, radius}; }
};

/// The face of a box that all of a circle is above or below, unless an edge of the box is near.
std::optional<Vector3d> face_below(const EdgeCircle& ring, const Vector3d& half) {
  const Vector3d over = ring.centre.cwiseAbs() - half;
  const Vector3d extent = (ring.u.cwiseAbs2() + ring.v.cwiseAbs2()).cwiseSqrt();
  Eigen::Index axis = 0;
  over.maxCoeff(&axis);
  Vector3d aside = over + extent;
  aside[axis] = -kFarAway;
  if (aside.maxCoeff() >= std::min(0.0, over[axis] - extent[axis])) return std::nullopt;
  return Vector3d::Unit(axis) * (ring.centre[axis] < 0.0 ? -1.0 : 1.0);
}

struct CircleRegion {
  Vector3d centre, axis;
  double radius = 0.0;

  [[nodiscard]] Disc about_axis(const Pose& X_FG) const { return disc(X_FG * centre, X_FG.linear().row(2).dot(axis)); }
  [[nodiscard]] Disc about_axis() const { return disc(centre, axis.z()); }

 private:
  /// A circle about nearly the same axis has nearly one r and one z.
  /// @param upright  cosine between the axes
  [[nodiscard]] Disc disc(const Vector3d& c, double upright) const {
    const double off = c.head<2>().norm();
    const double narrow = radius * std::min(1.0, std::abs(upright));
    const double low = std::max(0.0, narrow - off), high = radius + off;
    const double half = 0.5 * (high - low), up = std::sqrt(std::max(0.0, radius * radius - narrow * narrow));
    const double reach = std::sqrt(half * half + up * up);
    if (reach >= radius) return {{off, c.z()}, radius};
    return {{0.5 * (low + high), c.z()}, reach};
  }
};

}  // namespace

SurfacePoint SolidView::nearest_of_shape(const Vector3d& p_G) const {
  switch (shape) {
    case Shape::kPlane:
      return {.distance = p_G.z(), .flat = true};
    case Shape::kSphere:
      return nearest_of_ball(p_G, size[0]);
    case Shape::kCapsule:
      return nearest_of_ball(from_axis(p_G, size[1]), size[0]);
    case Shape::kCylinder:
      return outline->nearest(p_G);
    case Shape::kBox:
      return nearest_of_box(p_G, size);
    case Shape::kMesh:
      break;
  }
  return nearest_of_hull(p_G, *hull);
}

double SolidView::distance_of_shape(const Vector3d& p_G) const {
  switch (shape) {
    case Shape::kPlane:
      return p_G.z();
    case Shape::kSphere:
      return p_G.norm() - size[0];
    case Shape::kCapsule:
      return from_axis(p_G, size[1]).norm() - size[0];
    case Shape::kCylinder:
      return outline->distance(p_G);
    case Shape::kBox:
      return distance_of_box(p_G, size);
    case Shape::kMesh:
      break;
  }
  return distance_of_hull(p_G, *hull);
}

SurfacePoint SolidView::nearest_in_geom(const Vector3d& p_G) const { return NearSurface(*this).nearest(p_G); }

double SolidView::distance_in_geom(const Vector3d& p_G) const {
  double distance = distance_of_shape(p_G);
  if (!solid) return distance;
  for (const DrilledBore& bore : solid->bores) distance = std::max(distance, bore.material.distance(bore.X_BG * p_G));
  return distance;
}

Vector3d SolidView::axis_near(const Vector3d& p_G) const {
  const auto off_axis = [&](const DrilledBore& bore) { return (bore.X_BG * p_G).head<2>().squaredNorm(); };
  return std::ranges::min_element(solid->bores, {}, off_axis)->X_GB.linear().col(2);
}

NearSurface::NearSurface(const SolidView& solid) : solid_(&solid), least_(-kFarAway) {
  const std::size_t bores = solid.solid ? solid.solid->bores.size() : 0;
  whole_ = 1 + bores > kParts;
  if (whole_) return;
  parts_[count_++] = {};
  for (std::size_t i = 0; i < bores; ++i) parts_[count_++] = {.bore = &solid.solid->bores[i]};
}

NearSurface::NearSurface(const NearSurface& wider, const Vector3d& centre, double radius)
    : solid_(wider.solid_), least_(wider.least_) {
  narrow(wider, BallRegion{centre, radius});
}

NearSurface::NearSurface(const NearSurface& wider, const EdgeCircle& ring)
    : solid_(wider.solid_), least_(wider.least_) {
  narrow(wider, CircleRegion{ring.centre, ring.axis, ring.radius});
}

/// About the axis of a part, if it has one.
template <class Region>
const Revolved* NearSurface::outline_of(const Part& part, const Region& region, Disc& disc) const {
  if (part.bore) {
    disc = region.about_axis(part.bore->X_BG);
    return &part.bore->material;
  }
  if (solid_->outline) disc = region.about_axis();
  return solid_->outline;
}

template <class Region>
void NearSurface::narrow(const NearSurface& wider, const Region& region) {
  whole_ = wider.whole_;
  if (whole_) {
    least_ = std::max(least_, solid_->distance_in_geom(region.centre) - region.radius);
    return;
  }
  std::array<double, kParts> most;
  Disc disc;
  for (std::size_t i = 0; i < wider.count_; ++i) {
    const Revolved* outline = outline_of(wider.parts_[i], region, disc);
    const double distance = outline ? outline->distance(disc.middle) : solid_->distance_of_shape(region.centre);
    const double reach = outline ? disc.radius : region.radius;
    least_ = std::max(least_, distance - reach);
    most[i] = distance + reach;
  }
  if (free()) return;
  // The solid's distance is the largest of its parts' distances.
  for (std::size_t i = 0; i < wider.count_; ++i) {
    if (most[i] < least_) continue;
    Part& part = parts_[count_++] = wider.parts_[i];
    if (const Revolved* outline = outline_of(part, region, disc))
      part.lines = outline->lines_near(disc.middle, disc.radius);
  }
}

double NearSurface::distance(const Vector3d& p_G) const {
  if (whole_) return solid_->distance_in_geom(p_G);
  double most = -kFarAway;
  for (std::size_t i = 0; i < count_; ++i) {
    const Part& part = parts_[i];
    const double distance = part.bore         ? part.bore->material.distance(part.bore->X_BG * p_G, part.lines)
                            : solid_->outline ? solid_->outline->distance(p_G, part.lines)
                                              : solid_->distance_of_shape(p_G);
    most = std::max(most, distance);
  }
  return most;
}

std::optional<Vector3d> NearSurface::plane_below(const EdgeCircle& ring) const {
  if (whole_) return std::nullopt;
  std::optional<Vector3d> common;
  for (std::size_t i = 0; i < count_; ++i) {
    const Part& part = parts_[i];
    std::optional<Vector3d> normal;
    if (part.bore || solid_->outline) {
      const Revolved& outline = part.bore ? part.bore->material : *solid_->outline;
      const double along = outline.plane(part.lines);
      const Vector3d axis = part.bore ? Vector3d(part.bore->X_GB.linear().col(2)) : Vector3d::UnitZ();
      if (along != 0.0) normal = along * axis;
    } else if (solid_->shape == SolidView::Shape::kPlane) {
      normal = Vector3d::UnitZ();
    } else if (solid_->shape == SolidView::Shape::kBox) {
      normal = face_below(ring, solid_->size);
    }
    // Of parallel faces one is nearest to all points.
    if (!normal || (common && common->dot(*normal) < kParallel)) return std::nullopt;
    common = normal;
  }
  return common;
}

SurfacePoint NearSurface::nearest(const Vector3d& p_G) const {
  SurfacePoint surface{.distance = -kFarAway};
  const DrilledBore* of = nullptr;
  const auto look_at = [&](const Part& part) {
    const SurfacePoint found = part.bore         ? part.bore->material.nearest(part.bore->X_BG * p_G, part.lines)
                               : solid_->outline ? solid_->outline->nearest(p_G, part.lines)
                                                 : solid_->nearest_of_shape(p_G);
    if (found.distance <= surface.distance) return;
    surface = found;
    of = part.bore;
  };
  if (whole_) {
    look_at({});
    for (const DrilledBore& bore : solid_->solid->bores) look_at({.bore = &bore});
  } else {
    for (std::size_t i = 0; i < count_; ++i) look_at(parts_[i]);
  }
  if (of) surface.normal = of->X_GB.linear() * surface.normal;
  return surface;
}

}  // namespace takt::sim
