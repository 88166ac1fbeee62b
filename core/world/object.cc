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
  for (const Object::Part& part : object.parts) {
    nearest = std::min(nearest, signed_distance(part.shape, part.X_OS.inverse() * p_O));
  }
  return nearest;
}

MassProperties spread_mass(const std::vector<Object::Part>& parts, double mass, const std::vector<double>& masses) {
  double volume = 0.0;
  for (const Object::Part& part : parts) volume += solid(part.shape).volume;
  MassProperties sum;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Solid one = solid(parts[i].shape);
    const double own = masses.size() == parts.size() ? masses[i] : mass * one.volume / volume;
    sum = combine(sum, transform(parts[i].X_OS, {own, Vector3d::Zero(), (own * one.inertia).asDiagonal()}));
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
