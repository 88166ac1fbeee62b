#include "sim/contact/solid_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace takt::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Polygon = std::vector<Vector2d>;

constexpr int kSegments = 32;  // of a circle

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Twice the area of a triangle, positive counter-clockwise.
double turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) { return cross(b - a, c - a); }

bool cross_each_other(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  if (a == c || a == d || b == c || b == d) return false;
  return turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0;
}

/// A polygon by numbers of points, cut open to its holes one by one.
class Cutter {
 public:
  explicit Cutter(std::vector<Vector2d> points) : points_(std::move(points)) {}

  void begin(int count) {
    for (int i = 0; i < count; ++i) ring_.push_back(i);
  }
  void join(int first, int count, const std::vector<std::pair<int, int>>& walls);
  [[nodiscard]] std::vector<int> ears();

 private:
  [[nodiscard]] const Vector2d& at(int i) const { return points_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] bool visible(int a, int b, const std::vector<std::pair<int, int>>& walls) const;
  [[nodiscard]] bool is_ear(std::size_t i) const;

  std::vector<Vector2d> points_;
  std::vector<int> ring_;
};

bool Cutter::visible(int a, int b, const std::vector<std::pair<int, int>>& walls) const {
  const auto blocks = [&](int c, int d) { return cross_each_other(at(a), at(b), at(c), at(d)); };
  for (const auto& [c, d] : walls) {
    if (blocks(c, d)) return false;
  }
  for (std::size_t i = 0; i < ring_.size(); ++i) {
    if (blocks(ring_[i], ring_[(i + 1) % ring_.size()])) return false;
  }
  return true;
}

/// Puts a hole into the ring, there and back along the shortest line to it that nothing crosses.
void Cutter::join(int first, int count, const std::vector<std::pair<int, int>>& walls) {
  double shortest = std::numeric_limits<double>::infinity();
  std::size_t where = 0;
  int entry = first;
  for (std::size_t i = 0; i < ring_.size(); ++i) {
    for (int h = first; h < first + count; ++h) {
      const double length = (at(h) - at(ring_[i])).norm();
      if (length >= shortest || !visible(ring_[i], h, walls)) continue;
      shortest = length;
      where = i;
      entry = h;
    }
  }
  std::vector<int> detour;
  for (int i = 0; i <= count; ++i) detour.push_back(first + (entry - first + i) % count);
  detour.push_back(ring_[where]);
  ring_.insert(ring_.begin() + static_cast<std::ptrdiff_t>(where) + 1, detour.begin(), detour.end());
}

bool Cutter::is_ear(std::size_t i) const {
  const std::size_t n = ring_.size();
  const Vector2d &a = at(ring_[(i + n - 1) % n]), &b = at(ring_[i]), &c = at(ring_[(i + 1) % n]);
  if (turn(a, b, c) <= 0.0) return false;
  return std::ranges::none_of(ring_, [&](int other) {
    const Vector2d& p = at(other);
    if (p == a || p == b || p == c) return false;
    return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
  });
}

std::vector<int> Cutter::ears() {
  std::vector<int> corners;
  while (ring_.size() >= 3) {
    const std::size_t n = ring_.size();
    std::size_t ear = 0;
    while (ear < n && !is_ear(ear)) ++ear;
    if (ear == n) ear = 0;  // only slivers are left
    if (n == 3 || turn(at(ring_[(ear + n - 1) % n]), at(ring_[ear]), at(ring_[(ear + 1) % n])) > 0.0)
      corners.insert(corners.end(), {ring_[(ear + n - 1) % n], ring_[ear], ring_[(ear + 1) % n]});
    ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  return corners;
}

Polygon circle(const Vector2d& centre, double radius, bool clockwise) {
  Polygon points;
  for (int i = 0; i < kSegments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSegments * (clockwise ? -1.0 : 1.0);
    points.push_back(centre + radius * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

/// Collects the faces of one solid.
class Painter {
 public:
  PictureMesh mesh;

  /// A plane face with holes; z of its frame is out of the material.
  void face(const Pose& X_GF, const Polygon& outer, const std::vector<Polygon>& holes) {
    Polygon points = outer;
    for (const Polygon& hole : holes) points.insert(points.end(), hole.begin(), hole.end());
    const int first = static_cast<int>(mesh.vertices.size() / 3);
    for (const Vector2d& p : points) vertex(X_GF * Vector3d(p.x(), p.y(), 0.0), X_GF.linear().col(2));
    for (const int corner : triangulate(outer, holes)) mesh.corners.push_back(first + corner);
  }

  /// The surface between two circles about z of a frame. @param out  away from the axis, else towards it
  void band(const Pose& X, double r1, double z1, double r2, double z2, bool out) {
    const Vector2d along = Vector2d(r2 - r1, z2 - z1).normalized();
    const double sign = out ? 1.0 : -1.0;
    const Vector2d n = sign * (z2 > z1 ? Vector2d(along.y(), -along.x()) : Vector2d(-along.y(), along.x()));
    const int first = static_cast<int>(mesh.vertices.size() / 3);
    for (int i = 0; i <= kSegments; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kSegments;
      const double c = std::cos(angle), s = std::sin(angle);
      const Vector3d normal = X.linear() * Vector3d(n.x() * c, n.x() * s, n.y());
      vertex(X * Vector3d(r1 * c, r1 * s, z1), normal);
      vertex(X * Vector3d(r2 * c, r2 * s, z2), normal);
    }
    for (int i = 0; i < kSegments; ++i) {
      const int a = first + 2 * i;  // a, a + 1: from circle 1 to circle 2; a + 2, a + 3: the next
      if ((z2 > z1) == out) {
        mesh.corners.insert(mesh.corners.end(), {a, a + 2, a + 1, a + 1, a + 2, a + 3});
      } else {
        mesh.corners.insert(mesh.corners.end(), {a, a + 1, a + 2, a + 1, a + 3, a + 2});
      }
    }
  }

  void bore(const DrilledBore& bore) {
    const double r = bore.radius, c = bore.chamfer, end = -bore.length;
    const auto inward = [&](double r1, double z1, double r2, double z2) { band(bore.X_GB, r1, z1, r2, z2, false); };
    if (c > 0.0) inward(r + c, 0.0, r, -c);
    if (bore.through) {
      inward(r, -c, r, end + c);
      if (c > 0.0) inward(r, end + c, r + c, end);
      return;
    }
    inward(r, -c, r, end);
    face(bore.X_GB * Eigen::Translation3d(0, 0, end), circle({0, 0}, r, false), {});
  }

 private:
  void vertex(const Vector3d& p, const Vector3d& n) {
    for (int i = 0; i < 3; ++i) {
      mesh.vertices.push_back(static_cast<float>(p[i]));
      mesh.normals.push_back(static_cast<float>(n[i]));
    }
  }
};

/// The circles that bores leave in a face.
std::vector<Polygon> mouths_in(const Pose& X_GF, const Solid& solid) {
  constexpr double kSamePlane = 1e-6;
  std::vector<Polygon> holes;
  for (const DrilledBore& bore : solid.bores) {
    for (int end = 0; end < (bore.through ? 2 : 1); ++end) {
      const Vector3d p = X_GF.inverse() * (bore.X_GB * Vector3d(0, 0, end == 0 ? 0.0 : -bore.length));
      const double along = X_GF.linear().col(2).dot(bore.X_GB.linear().col(2)) * (end == 0 ? 1.0 : -1.0);
      if (std::abs(p.z()) < kSamePlane && along > 0.99)
        holes.push_back(circle(p.head<2>(), bore.radius + bore.chamfer, true));
    }
  }
  return holes;
}

void paint_box(const Vector3d& size, const Solid& solid, Painter& painter) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      Pose X_GF = Pose::Identity();
      X_GF.linear() << Vector3d::Unit(u), side * Vector3d::Unit(v), side * Vector3d::Unit(axis);
      X_GF.translation() = 0.5 * side * size[axis] * Vector3d::Unit(axis);
      const double a = 0.5 * size[u], b = 0.5 * size[v];
      painter.face(X_GF, {{-a, -b}, {a, -b}, {a, b}, {-a, b}}, mouths_in(X_GF, solid));
    }
  }
}

void paint_cylinder(const kinematics::Cylinder& cylinder, const Solid& solid, Painter& painter) {
  const double r = cylinder.radius, h = 0.5 * cylinder.length, c = solid.chamfer;
  const Pose X = Pose::Identity();
  painter.band(X, r, c - h, r, h - c, true);
  if (c > 0.0) {
    painter.band(X, r - c, -h, r, c - h, true);
    painter.band(X, r, h - c, r - c, h, true);
  }
  for (const double side : {-1.0, 1.0}) {
    Pose X_GF = Pose::Identity();
    X_GF.linear() << Vector3d::UnitX(), side * Vector3d::UnitY(), side * Vector3d::UnitZ();
    X_GF.translation().z() = side * h;
    painter.face(X_GF, circle({0, 0}, r - c, false), mouths_in(X_GF, solid));
  }
}

}  // namespace

std::vector<int> triangulate(const std::vector<Vector2d>& outer, const std::vector<std::vector<Vector2d>>& holes) {
  Polygon points = outer;
  std::vector<std::pair<int, int>> walls;
  std::vector<int> first;
  for (const Polygon& hole : holes) {
    first.push_back(static_cast<int>(points.size()));
    const int count = static_cast<int>(hole.size());
    for (int i = 0; i < count; ++i) walls.emplace_back(first.back() + i, first.back() + (i + 1) % count);
    points.insert(points.end(), hole.begin(), hole.end());
  }
  Cutter cutter(std::move(points));
  cutter.begin(static_cast<int>(outer.size()));
  for (std::size_t i = 0; i < holes.size(); ++i) cutter.join(first[i], static_cast<int>(holes[i].size()), walls);
  return cutter.ears();
}

PictureMesh picture_of(const ObjectShape& shape, const Solid& solid) {
  Painter painter;
  if (const auto* box = std::get_if<kinematics::Box>(&shape)) paint_box(box->size, solid, painter);
  if (const auto* cylinder = std::get_if<kinematics::Cylinder>(&shape)) paint_cylinder(*cylinder, solid, painter);
  for (const DrilledBore& bore : solid.bores) painter.bore(bore);
  return std::move(painter.mesh);
}

}  // namespace takt::sim
