#include "core/world/revolved.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace takt::world {
namespace {

constexpr double kCoincident = 1e-12;  // m

}  // namespace

Revolved::Revolved(std::initializer_list<Point> outline) {
  for (const Point& point : outline) {
    const Eigen::Vector2d p(point.r, point.z);
    if (count_ > 0 && (p - points_[count_ - 1]).norm() < kCoincident) continue;
    if (count_ < kPoints) points_[count_++] = p;
  }
}

Eigen::Vector2d Revolved::normal(std::size_t line) const {
  const Eigen::Vector2d along = (points_[line + 1] - points_[line]).normalized();
  return {along.y(), -along.x()};
}

SurfacePoint Revolved::nearest(const Eigen::Vector3d& p) const {
  const Eigen::Vector2d at(std::hypot(p.x(), p.y()), p.z());
  double best = std::numeric_limits<double>::infinity();
  std::size_t line = 0;
  double share = 0.0;
  for (std::size_t i = 0; i + 1 < count_; ++i) {
    const Eigen::Vector2d along = points_[i + 1] - points_[i];
    const double s = std::clamp((at - points_[i]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    const double squared = (at - points_[i] - s * along).squaredNorm();
    if (squared >= best) continue;
    best = squared;
    line = i;
    share = s;
  }
  SurfacePoint surface;
  Eigen::Vector2d n = normal(line);
  const Eigen::Vector2d off = at - points_[line] - share * (points_[line + 1] - points_[line]);
  const bool corner = (share <= 0.0 && line > 0) || (share >= 1.0 && line + 2 < count_);
  if (corner) {
    // Which side of a corner a point is on is what the sum of the two normals says.
    const Eigen::Vector2d both = n + normal(share <= 0.0 ? line - 1 : line + 1);
    const double length = std::sqrt(best);
    const bool outside = off.dot(both) > 0.0;
    surface.distance = outside ? length : -length;
    surface.edge = true;
    n = length > kCoincident ? Eigen::Vector2d((outside ? off : Eigen::Vector2d(-off)) / length) : both.normalized();
  } else {
    surface.distance = off.dot(n);
    surface.flat = std::abs(n.x()) < kCoincident;
  }
  const Eigen::Vector2d out = at.x() > kCoincident ? Eigen::Vector2d(p.head<2>() / at.x()) : Eigen::Vector2d::UnitX();
  surface.normal << n.x() * out, n.y();
  return surface;
}

}  // namespace takt::world
