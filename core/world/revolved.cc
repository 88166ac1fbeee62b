#include "core/world/revolved.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace takt::world {
namespace {

using Eigen::Vector2d;

constexpr double kCoincident = 1e-12;  // m
constexpr double kRounding = 1e-11;    // m: lines may begin a kilometre away

}  // namespace

Revolved::Revolved(std::initializer_list<Point> outline) {
  Vector2d last = Vector2d::Zero();
  bool first = true;
  for (const Point& point : outline) {
    const Vector2d p(point.r, point.z);
    const double length = (p - last).norm();
    if (!first && length < kCoincident) continue;
    if (!first && count_ < lines_.size()) {
      const Vector2d along = (p - last) / length;
      lines_[count_++] = {.from = last, .along = along, .normal = {along.y(), -along.x()}, .length = length};
    }
    last = p;
    first = false;
  }
  for (std::size_t i = 1; i < count_; ++i) corner_normals_[i] = lines_[i - 1].normal + lines_[i].normal;
}

Revolved::Nearest Revolved::nearest_line(const Vector2d& at, Lines lines) const {
  Nearest best{.squared = std::numeric_limits<double>::infinity()};
  for (unsigned left = lines & ((1U << count_) - 1U); left != 0; left &= left - 1U) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    const Line& line = lines_[i];
    const Vector2d off = at - line.from;
    const double along = off.dot(line.along), aside = off.dot(line.normal);
    const double on = std::clamp(along, 0.0, line.length), beyond = along - on;
    const double squared = aside * aside + beyond * beyond;
    if (squared >= best.squared) continue;
    const int corner = on <= 0.0 && i > 0 ? -1 : on >= line.length && i + 1 < count_ ? 1 : 0;
    best = {.line = i, .along = along, .aside = aside, .squared = squared, .corner = corner};
  }
  return best;
}

/// Which side of a corner a point is on is what the sum of the two normals says.
bool Revolved::is_free(const Nearest& found) const {
  const Line& line = lines_[found.line];
  const double beyond = found.corner < 0 ? found.along : found.along - line.length;
  const Vector2d off = found.aside * line.normal + beyond * line.along;
  return off.dot(corner_normals_[found.line + (found.corner < 0 ? 0 : 1)]) > 0.0;
}

double Revolved::distance(const Point& at, Lines lines) const {
  const Nearest found = nearest_line({at.r, at.z}, lines);
  if (found.corner == 0) return found.aside;
  const double length = std::sqrt(found.squared);
  return is_free(found) ? length : -length;
}

double Revolved::distance(const Eigen::Vector3d& p, Lines lines) const {
  return distance(Point{std::sqrt(p.x() * p.x() + p.y() * p.y()), p.z()}, lines);
}

SurfacePoint Revolved::nearest(const Eigen::Vector3d& p, Lines lines) const {
  const double r = std::sqrt(p.x() * p.x() + p.y() * p.y());
  const Nearest found = nearest_line({r, p.z()}, lines);
  const Line& line = lines_[found.line];
  SurfacePoint surface;
  Vector2d n = line.normal;
  if (found.corner != 0) {
    const double length = std::sqrt(found.squared);
    const bool free = is_free(found);
    surface.distance = free ? length : -length;
    surface.edge = true;
    if (length > kCoincident) {
      const double beyond = found.corner < 0 ? found.along : found.along - line.length;
      n = (found.aside * line.normal + beyond * line.along) / surface.distance;
    } else {
      n = corner_normals_[found.line + (found.corner < 0 ? 0 : 1)].normalized();
    }
  } else {
    surface.distance = found.aside;
    surface.flat = std::abs(n.x()) < kCoincident;
  }
  const double across = r > kCoincident ? n.x() / r : 0.0;
  surface.normal = Eigen::Vector3d(r > kCoincident ? across * p.x() : n.x(), across * p.y(), n.y());
  return surface;
}

Revolved::Lines Revolved::lines_near(const Point& at, double radius) const {
  std::array<double, kPoints - 1> distances{};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count_; ++i) {
    distances[i] = std::sqrt(nearest_line({at.r, at.z}, static_cast<Lines>(1U << i)).squared);
    least = std::min(least, distances[i]);
  }
  Lines lines = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (distances[i] <= least + 2.0 * radius + kRounding) lines = static_cast<Lines>(lines | (1U << i));
  }
  return lines;
}

double Revolved::plane(Lines lines) const {
  const unsigned known = lines & ((1U << count_) - 1U);
  if (!std::has_single_bit(known)) return 0.0;
  const Vector2d& normal = lines_[static_cast<std::size_t>(std::countr_zero(known))].normal;
  return std::abs(normal.x()) < kCoincident ? std::copysign(1.0, normal.y()) : 0.0;
}

}  // namespace takt::world
