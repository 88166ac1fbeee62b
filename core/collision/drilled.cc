#include "core/collision/drilled.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace takt::collision {
namespace {

using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;

constexpr double kExcess = 2e-4;  // m: by how much a prism may differ from its circle
constexpr double kThin = 1e-7;    // m: thinner pieces are none

/// The side of a plane on which n.p <= d.
struct HalfSpace {
  Vector3d n = Vector3d::UnitZ();  ///< unit
  double d = 0.0;

  [[nodiscard]] double outside(const Vector3d& p) const { return n.dot(p) - d; }
  [[nodiscard]] HalfSpace other() const { return {-n, -d}; }
};

/// A convex body by its faces.
using Polytope = std::vector<Polygon>;

/// Corners of the section of a body in the order in which they follow each other around it.
Polygon around(Polygon points, const Vector3d& n) {
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : points) middle += p / static_cast<double>(points.size());
  const Vector3d u = n.unitOrthogonal(), v = n.cross(u);
  const auto angle = [&](const Vector3d& p) { return std::atan2(v.dot(p - middle), u.dot(p - middle)); };
  std::ranges::sort(points, {}, angle);
  const auto same = std::ranges::unique(points, [](const auto& a, const auto& b) { return (a - b).norm() < kThin; });
  points.erase(same.begin(), same.end());
  return points;
}

/// The part of a face on one side of a plane. @param section  gets the points on the plane
Polygon clipped(const Polygon& face, const HalfSpace& side, Polygon& section) {
  Polygon kept;
  for (std::size_t i = 0; i < face.size(); ++i) {
    const Vector3d &p = face[i], &next = face[(i + 1) % face.size()];
    const double here = side.outside(p), there = side.outside(next);
    if (here <= 0.0) kept.push_back(p);
    if ((here <= 0.0) == (there <= 0.0)) continue;
    kept.push_back(p + here / (here - there) * (next - p));
    section.push_back(kept.back());
  }
  return kept;
}

/// Nothing: no more of the body than a film is on that side.
std::optional<Polytope> clipped(const Polytope& body, const HalfSpace& side) {
  double deepest = 0.0, farthest = 0.0;
  for (const Polygon& face : body) {
    for (const Vector3d& p : face) {
      deepest = std::min(deepest, side.outside(p));
      farthest = std::max(farthest, side.outside(p));
    }
  }
  if (deepest > -kThin) return std::nullopt;
  if (farthest < kThin) return body;
  Polytope kept;
  Polygon section;
  for (const Polygon& face : body)
    if (Polygon rest = clipped(face, side, section); rest.size() > 2) kept.push_back(std::move(rest));
  if (section.size() > 2) kept.push_back(around(std::move(section), side.n));
  return kept;
}

/// The number of sides with which a prism differs from a circle by kExcess, a multiple of four.
int sides_of(double radius) {
  const double angle = std::acos(std::max(0.0, 1.0 - kExcess / radius));
  return std::clamp(4 * static_cast<int>(std::ceil(0.25 * std::numbers::pi / angle)), 8, 48);
}

/// Directions of the sides of a prism about z.
std::vector<Vector3d> sides(int count) {
  std::vector<Vector3d> made;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + 0.5) / count;
    made.emplace_back(std::cos(angle), std::sin(angle), 0.0);
  }
  return made;
}

Polytope box(const Vector3d& half) {
  Polytope faces;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Polygon& face = faces.emplace_back();
      for (const auto& [a, b] : {std::pair(-1.0, -1.0), {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
        Vector3d p;
        p[axis] = sign * half[axis];
        p[(axis + 1) % 3] = a * half[(axis + 1) % 3];
        p[(axis + 2) % 3] = b * half[(axis + 2) % 3];
        face.push_back(p);
      }
    }
  }
  return faces;
}

/// A box, or a prism around a cylinder.
Polytope polytope_of(const world::Shape& shape) {
  if (const auto* one = std::get_if<world::Box>(&shape)) return box(0.5 * one->size);
  const auto& cylinder = std::get<world::Cylinder>(shape);
  Polytope prism = box({2.0 * cylinder.radius, 2.0 * cylinder.radius, 0.5 * cylinder.length});
  for (const Vector3d& n : sides(sides_of(cylinder.radius)))
    if (auto cut = clipped(prism, HalfSpace{n, cylinder.radius})) prism = std::move(*cut);
  return prism;
}

/// What bounds the hole, first the bottom, then a square around it, so that cuts end near it.
std::vector<HalfSpace> hole_of(const world::Bore& bore) {
  std::vector<HalfSpace> hole;
  if (!bore.through()) hole.push_back({-Vector3d::UnitZ(), bore.depth});
  for (const Vector3d& axis : {Vector3d::UnitX().eval(), Vector3d::UnitY().eval()})
    for (const double sign : {-1.0, 1.0}) hole.push_back({sign * axis, bore.radius});
  const int count = sides_of(bore.radius);
  for (const Vector3d& n : sides(count)) hole.push_back({n, bore.radius * std::cos(std::numbers::pi / count)});
  for (HalfSpace& side : hole) {
    side.n = bore.X_SB.linear() * side.n;
    side.d += side.n.dot(bore.X_SB.translation());
  }
  return hole;
}

/// What is left of a body without the hole, in pieces.
void drill(const Polytope& body, const std::vector<HalfSpace>& hole, std::vector<Polytope>& pieces) {
  std::optional<Polytope> rest = body;
  for (const HalfSpace& side : hole)
    if (rest) rest = clipped(*rest, side);
  if (!rest) return pieces.push_back(body);  // they do not meet
  rest = body;
  for (const HalfSpace& side : hole) {
    if (auto piece = clipped(*rest, side.other())) pieces.push_back(std::move(*piece));
    rest = clipped(*rest, side);
    if (!rest) return;
  }
}

std::optional<Convex> convex(const Polytope& body) {
  std::vector<Vector3d> corners;
  for (const Polygon& face : body) corners.insert(corners.end(), face.begin(), face.end());
  auto hull = Convex::hull(corners);
  return hull ? std::optional(std::move(*hull)) : std::nullopt;
}

}  // namespace

std::vector<Part> solids_of(const world::Object::Part& part) {
  if (part.bores.empty()) return {{Convex::from(part.shape), part.X_OS}};
  std::vector<Polytope> pieces{polytope_of(part.shape)};
  for (const world::Bore& bore : part.bores) {
    const std::vector<HalfSpace> hole = hole_of(bore);
    std::vector<Polytope> left;
    for (const Polytope& piece : pieces) drill(piece, hole, left);
    pieces = std::move(left);
  }
  std::vector<Part> solids;
  for (const Polytope& piece : pieces)
    if (auto solid = convex(piece)) solids.push_back({std::move(*solid), part.X_OS});
  return solids;
}

}  // namespace takt::collision
