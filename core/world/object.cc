#include "core/world/object.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace takt::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Of a point mass at p about the origin.
Matrix3d point_inertia(double mass, const Vector3d& p) {
  return mass * (p.squaredNorm() * Matrix3d::Identity() - p * p.transpose());
}

// -- Solids: volume in m^3, and inertia about the centre of a body of 1 kg
// ---------------------------------------------

struct Solid {
  double volume = 0.0;
  Vector3d inertia = Vector3d::Zero();  ///< main diagonal, m^2
};

Solid solid(const Box& box) {
  const Eigen::Array3d s = box.size.array().square();
  return {box.size.prod(), Vector3d(s[1] + s[2], s[0] + s[2], s[0] + s[1]) / 12.0};
}

Solid solid(const Cylinder& cylinder) {
  const double r = cylinder.radius * cylinder.radius, across = r / 4.0 + cylinder.length * cylinder.length / 12.0;
  return {std::numbers::pi * r * cylinder.length, {across, across, r / 2.0}};
}

Solid solid(const Sphere& sphere) {
  const double r = sphere.radius * sphere.radius;
  return {4.0 / 3.0 * std::numbers::pi * r * sphere.radius, Vector3d::Constant(0.4 * r)};
}

/// A cylinder and two half balls, whose centres of mass are 3/8 r from their flat sides.
Solid solid(const Capsule& capsule) {
  const double r = capsule.radius;
  const Solid middle = solid(Cylinder{r, capsule.length}), ball = solid(Sphere{r});
  const double volume = middle.volume + ball.volume, share = ball.volume / volume;
  const double flat = 0.5 * capsule.length, centre = flat + 0.375 * r;
  const double half_across = 0.4 * r * r - std::pow(0.375 * r, 2) + centre * centre;
  const double across = (1.0 - share) * middle.inertia.x() + share * half_across;
  return {volume, {across, across, (1.0 - share) * middle.inertia.z() + share * 0.4 * r * r}};
}

Solid solid(const Shape& shape) {
  return std::visit([](const auto& s) { return solid(s); }, shape);
}

// -- Chamfers and bores: bodies of density 1, whose mass is their volume ----------------------------------------------

/// Of a cone without its tip about z, from radius r1 at z1 up to r2 at z2.
MassProperties cone(double r1, double z1, double r2, double z2) {
  // Of the integrals over r^2, z r^2, z^2 r^2 and r^4 three points of Gauss are exact.
  constexpr double kPoint = 0.7745966692414834, kEnd = 5.0 / 18.0, kMiddle = 4.0 / 9.0;
  double volume = 0.0, first = 0.0, second = 0.0, polar = 0.0;
  for (const auto& [at, weight] : {std::pair(-kPoint, kEnd), {0.0, kMiddle}, {kPoint, kEnd}}) {
    const double share = 0.5 + 0.5 * at, r = r1 + share * (r2 - r1), z = z1 + share * (z2 - z1);
    const double slice = weight * std::numbers::pi * r * r * (z2 - z1);
    volume += slice;
    first += slice * z;
    second += slice * z * z;
    polar += slice * r * r / 2.0;
  }
  if (volume == 0.0) return {};
  const double across = polar / 2.0 + second - first * first / volume;
  return {volume, Vector3d(0, 0, first / volume), Vector3d(across, across, polar).asDiagonal()};
}

MassProperties chamfered(const Cylinder& cylinder, double chamfer) {
  const double h = 0.5 * cylinder.length, r = cylinder.radius;
  return combine(combine(cone(r - chamfer, -h, r, chamfer - h), cone(r, chamfer - h, r, h - chamfer)),
                 cone(r, h - chamfer, r - chamfer, h));
}

/// How thick a box or cylinder is below the mouth of a bore, m.
double thickness_below(const Shape& shape, const Bore& bore) {
  if (const auto* box = std::get_if<Box>(&shape)) {
    Eigen::Index axis = 0;
    bore.X_SB.linear().col(2).cwiseAbs().maxCoeff(&axis);
    return box->size[axis];
  }
  const auto* cylinder = std::get_if<Cylinder>(&shape);
  return cylinder ? cylinder->length : 0.0;
}

/// What is missing where the bore is, in its frame.
MassProperties removed(const Shape& shape, const Bore& bore) {
  const double end = bore.through() ? -thickness_below(shape, bore) : -bore.depth;
  const double r = bore.radius, c = bore.chamfer, wall = bore.through() ? end + c : end;
  const MassProperties hole = combine(cone(r, wall, r, -c), cone(r, -c, r + c, 0.0));
  return bore.through() ? combine(cone(r + c, end, r, wall), hole) : hole;
}

bool is_plain(const Object::Part& part) { return part.chamfer == 0.0 && part.bores.empty(); }

MassProperties unit_body(const Object::Part& part) {
  const auto* cylinder = std::get_if<Cylinder>(&part.shape);
  const Solid whole = solid(part.shape);
  MassProperties body =
      cylinder && part.chamfer > 0.0
          ? chamfered(*cylinder, part.chamfer)
          : MassProperties{whole.volume, Vector3d::Zero(), Vector3d(whole.volume * whole.inertia).asDiagonal()};
  for (const Bore& bore : part.bores) {
    const MassProperties hole = transform(bore.X_SB, removed(part.shape, bore));
    body = combine(body, {-hole.mass, hole.p_OC, -hole.I_C});
  }
  return body;
}

/// A part of this mass, in the frame of its shape.
MassProperties body_of(const Object::Part& part, double mass) {
  if (is_plain(part)) return {mass, Vector3d::Zero(), (mass * solid(part.shape).inertia).asDiagonal()};
  const MassProperties unit = unit_body(part);
  return {mass, unit.p_OC, mass / unit.mass * unit.I_C};
}

// -- Distances --------------------------------------------------------------------------------------------------------

/// What the shape and the surroundings of each bore have in common is material. @param p  in the frame of the shape
double distance_to(const Object::Part& part, const Vector3d& p) {
  const auto* cylinder = std::get_if<Cylinder>(&part.shape);
  double distance = cylinder && part.chamfer > 0.0
                        ? chamfered_cylinder(cylinder->radius, cylinder->length, part.chamfer).nearest(p).distance
                        : signed_distance(part.shape, p);
  for (const Bore& bore : part.bores) {
    const Revolved around = material_around(bore, thickness_below(part.shape, bore));
    distance = std::max(distance, around.nearest(bore.X_SB.inverse() * p).distance);
  }
  return distance;
}

// -- Outlines ---------------------------------------------------------------------------------------------------------

void add_outline(const Box& box, std::vector<Vector3d>& points) {
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d sign((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
    points.push_back(0.5 * box.size.cwiseProduct(sign));
  }
}

void add_rims(double radius, double half, std::vector<Vector3d>& points) {
  constexpr int kPoints = 8;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPoints;
    const Vector3d rim(radius * std::cos(angle), radius * std::sin(angle), half);
    points.push_back(rim);
    points.emplace_back(rim.x(), rim.y(), -half);
  }
}

void add_outline(const Cylinder& cylinder, std::vector<Vector3d>& points) {
  add_rims(cylinder.radius, 0.5 * cylinder.length, points);
}

void add_outline(const Sphere& sphere, std::vector<Vector3d>& points) {
  for (int axis = 0; axis < 3; ++axis) {
    points.push_back(sphere.radius * Vector3d::Unit(axis));
    points.push_back(-sphere.radius * Vector3d::Unit(axis));
  }
}

void add_outline(const Capsule& capsule, std::vector<Vector3d>& points) {
  const double half = 0.5 * capsule.length;
  add_rims(capsule.radius, half, points);
  points.emplace_back(0.0, 0.0, half + capsule.radius);
  points.emplace_back(0.0, 0.0, -half - capsule.radius);
}

}  // namespace

MassProperties transform(const Eigen::Isometry3d& X_AO, const MassProperties& body) {
  return {body.mass, X_AO * body.p_OC, X_AO.linear() * body.I_C * X_AO.linear().transpose()};
}

MassProperties combine(const MassProperties& a, const MassProperties& b) {
  if (b.mass == 0.0) return a;
  if (a.mass == 0.0) return b;
  const double mass = a.mass + b.mass;
  const Vector3d centre = (a.mass * a.p_OC + b.mass * b.p_OC) / mass;
  return {mass, centre,
          a.I_C + b.I_C + point_inertia(a.mass, a.p_OC - centre) + point_inertia(b.mass, b.p_OC - centre)};
}

double signed_distance(const Object& object, const Vector3d& p_O) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Object::Part& part : object.parts)
    nearest = std::min(nearest, distance_to(part, part.X_OS.inverse() * p_O));
  return nearest;
}

double volume(const Object::Part& part) { return is_plain(part) ? solid(part.shape).volume : unit_body(part).mass; }

MassProperties spread_mass(const std::vector<Object::Part>& parts, double mass, const std::vector<double>& masses) {
  double whole = 0.0;
  for (const Object::Part& part : parts) whole += volume(part);
  MassProperties sum;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double own = masses.size() == parts.size() ? masses[i] : mass * volume(parts[i]) / whole;
    sum = combine(sum, transform(parts[i].X_OS, body_of(parts[i], own)));
  }
  return sum;
}

std::vector<Vector3d> outline(const Object& object) {
  std::vector<Vector3d> points;
  for (const Object::Part& part : object.parts) {
    const std::size_t before = points.size();
    std::visit([&](const auto& shape) { add_outline(shape, points); }, part.shape);
    for (std::size_t i = before; i < points.size(); ++i) points[i] = part.X_OS * points[i];
  }
  return points;
}

}  // namespace takt::world
