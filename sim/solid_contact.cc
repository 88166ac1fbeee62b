#include "sim/solid_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace takt::sim {
namespace {

using Eigen::Vector3d;
using world::SurfacePoint;

constexpr int kScan = 48;            // points of a circle that are looked at first
constexpr int kSpread = 8;           // points of a circle that may touch at once, evenly about the deepest
constexpr int kEdgeScan = 8;         // pieces of an edge
constexpr int kRefinements = 14;     // of a deepest point; the error falls as a square
constexpr double kNear = 0.35;       // rad: nearer than this to a deepest point is the same contact
constexpr double kSteep = 0.5;       // of a normal along the axis of an edge
constexpr double kHalves = 1.0;      // rad: where the halves of an edge meet; not where symmetric contacts are
constexpr double kProminent = 1e-9;  // m: by which a deepest point beats its neighbours
constexpr double kDeep = 2e-3;       // m below the face: deeper than what rests on the face sinks in
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kFlatGroups = 7;  // numbers of springs on plane faces: below this

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

SurfacePoint nearest_of_ball(const Vector3d& p, double radius) {
  const double length = p.norm();
  return {.distance = length - radius, .normal = length > 0.0 ? Vector3d(p / length) : Vector3d::UnitZ()};
}

SurfacePoint nearest_of_capsule(const Vector3d& p, double radius, double half) {
  return nearest_of_ball(p - Vector3d(0, 0, std::clamp(p.z(), -half, half)), radius);
}

SurfacePoint nearest_of_hull(const Vector3d& p, const MeshHull& hull) {
  SurfacePoint surface{.distance = -std::numeric_limits<double>::infinity(), .flat = true};
  for (const Eigen::Vector4d& plane : hull.planes) {
    const double distance = plane.head<3>().dot(p) - plane[3];
    if (distance <= surface.distance) continue;
    surface.distance = distance;
    surface.normal = plane.head<3>();
  }
  return surface;
}

/// The deepest point between two that slope towards each other.
/// @param at     point of a parameter, with what it is a point of
/// @param slope  of the distance there, per unit of the parameter
template <class Slope>
double deepest(double low, double high, const Slope& slope) {
  double at_low = slope(low), at_high = slope(high);
  if (at_low >= 0.0) return low;
  if (at_high <= 0.0) return high;
  double best = 0.5 * (low + high);
  for (int i = 0; i < kRefinements; ++i) {
    // Illinois: a secant that halves the end which stays.
    best = (low * at_high - high * at_low) / (at_high - at_low);
    const double here = slope(best);
    if (here == 0.0) return best;
    if (here > 0.0) {
      high = best;
      at_high = here;
      at_low *= 0.5;
    } else {
      low = best;
      at_low = here;
      at_high *= 0.5;
    }
  }
  return best;
}

}  // namespace

SurfacePoint SolidView::nearest_of_shape(const Vector3d& p_G) const {
  switch (shape) {
    case Shape::kPlane:
      return {.distance = p_G.z(), .flat = true};
    case Shape::kSphere:
      return nearest_of_ball(p_G, size[0]);
    case Shape::kCapsule:
      return nearest_of_capsule(p_G, size[0], size[1]);
    case Shape::kCylinder:
      return outline.nearest(p_G);
    case Shape::kBox:
      return nearest_of_box(p_G, size);
    case Shape::kMesh:
      break;
  }
  return nearest_of_hull(p_G, *hull);
}

SurfacePoint SolidView::nearest(const Vector3d& p_W) const {
  const Vector3d p_G = X_W.inverse(Eigen::Isometry) * p_W;
  SurfacePoint surface = nearest_of_shape(p_G);
  if (solid) {
    // What the shape and each bore's surroundings have in common is material.
    for (const DrilledBore& bore : solid->bores) {
      SurfacePoint around = bore.material.nearest(bore.X_GB.inverse(Eigen::Isometry) * p_G);
      if (around.distance <= surface.distance) continue;
      around.normal = bore.X_GB.linear() * around.normal;
      surface = around;
    }
  }
  surface.normal = X_W.linear() * surface.normal;
  return surface;
}

Vector3d SolidView::axis_near(const Vector3d& p_W) const {
  const Vector3d p_G = X_W.inverse(Eigen::Isometry) * p_W;
  const auto off_axis = [&](const DrilledBore& bore) {
    return (bore.X_GB.inverse(Eigen::Isometry) * p_G).head<2>().squaredNorm();
  };
  const auto nearest = std::ranges::min_element(solid->bores, {}, off_axis);
  return X_W.linear() * nearest->X_GB.linear().col(2);
}

// -- Edges of one solid against the surface of the other --------------------------------------------------------------

/// An edge of a solid of revolution, in the world.
struct Touches::Circle {
  Vector3d centre, u, v;  ///< u and v across the axis, as long as the radius

  [[nodiscard]] Vector3d at(double angle) const { return centre + std::cos(angle) * u + std::sin(angle) * v; }
  [[nodiscard]] Vector3d along(double angle) const { return std::cos(angle) * v - std::sin(angle) * u; }
};

/// Whose edges, against whose surface.
struct Touches::Side {
  const SolidView& edges;
  const SolidView& surface;
  bool first = true;  ///< the edges are those of the first solid
  const SolidView& drilled;
};

std::uint8_t Touches::flat_group(const SolidView& drilled, const Vector3d& normal) {
  const Vector3d n = drilled.X_W.linear().transpose() * normal;
  Eigen::Index axis = 0;
  n.cwiseAbs().maxCoeff(&axis);
  return static_cast<std::uint8_t>(1 + 2 * axis + (n[axis] < 0.0 ? 1 : 0));
}

void Touches::add(const Touch& touch) {
  if (count_ < kCapacity) touches_[count_++] = touch;
}

void Touches::emit(const Side& side, const Vector3d& p_W, const SurfacePoint& surface, int feature) {
  constexpr int kFeatures = 60;
  Touch touch;
  touch.depth = -surface.distance;
  touch.position = p_W + 0.5 * touch.depth * surface.normal;
  touch.normal = side.first ? Vector3d(-surface.normal) : surface.normal;
  touch.group = surface.flat
                    ? flat_group(side.drilled, touch.normal)
                    : static_cast<std::uint8_t>(kFlatGroups + feature % kFeatures + (side.first ? 0 : kFeatures));
  add(touch);
}

/// The points of an edge from number `first` on, against curved faces, as one spring with the energy
/// k/2 (sum d^8)^(1/4): that of the deepest point where it is alone, a little stiffer the more of the edge bears, and a
/// force that comes from an energy.
void Touches::weigh(std::size_t first) {
  const auto power = [](double depth, int doublings) {
    for (int i = 0; i < doublings; ++i) depth *= depth;
    return depth;
  };
  double deepest_of_all = 0.0, sum = 0.0;
  for (std::size_t i = first; i < count_; ++i) {
    if (touches_[i].group >= kFlatGroups) deepest_of_all = std::max(deepest_of_all, touches_[i].depth);
  }
  for (std::size_t i = first; i < count_; ++i) {
    if (touches_[i].group >= kFlatGroups) sum += power(touches_[i].depth / deepest_of_all, 3);
  }
  for (std::size_t i = first; i < count_; ++i) {
    Touch& touch = touches_[i];
    if (touch.group < kFlatGroups) continue;
    const double squared = power(touch.depth / deepest_of_all, 1);
    touch.weight = squared * squared * squared / std::sqrt(sum * std::sqrt(sum));
  }
}

void Touches::corner(const Side& side, const Vector3d& p_W, int feature) {
  if (const SurfacePoint surface = side.surface.nearest(p_W); surface.distance < 0.0)
    emit(side, p_W, surface, 2 * feature);
}

/// A ball touches a face at one point, and a bore around its axis at up to a whole circle. Edges are the other's to
/// find.
void Touches::ball(const Side& side, const Vector3d& centre, double radius, int feature) {
  SurfacePoint surface = side.surface.nearest(centre);
  if (surface.distance >= radius || surface.edge) return;
  const Vector3d deepest = -radius * surface.normal;
  surface.distance -= radius;
  const std::size_t first = count_;
  emit(side, centre + deepest, surface, 2 * feature);
  weigh(first);
  if (surface.flat || !side.surface.drilled()) return;
  const Vector3d axis = side.surface.axis_near(centre);
  for (int i = 1; i < kSpread; ++i) {
    const Vector3d p = centre + Eigen::AngleAxisd(kTurn * i / kSpread, axis) * deepest;
    const SurfacePoint here = side.surface.nearest(p);
    if (here.distance < 0.0 && !here.flat) emit(side, p, here, 2 * feature);
  }
  weigh(first);
}

void Touches::circle(const Side& side, const Circle& circle, int feature) {
  const SolidView& other = side.surface;
  if (other.nearest(circle.centre).distance > circle.u.norm()) return;
  std::array<double, kScan> distance{};
  for (int i = 0; i < kScan; ++i)
    distance[static_cast<std::size_t>(i)] = other.nearest(circle.at(kTurn * i / kScan)).distance;
  const auto scanned = [&](int i) { return distance[static_cast<std::size_t>((i + kScan) % kScan)]; };
  const auto slope = [&](double angle) { return other.nearest(circle.at(angle)).normal.dot(circle.along(angle)); };
  // Between two points of the scan the distance falls below both by no more than this.
  const double sag = circle.u.norm() * kTurn / kScan;

  std::array<double, kScan + kSpread> angles{};
  std::size_t used = 0;
  const auto minimum = [&](int i) {
    double angle = deepest(kTurn * (i - 1) / kScan, kTurn * (i + 1) / kScan, slope);
    if (other.nearest(circle.at(angle)).distance > scanned(i)) angle = kTurn * i / kScan;
    angles[used++] = angle;
  };
  int lowest = 0;
  for (int i = 1; i < kScan; ++i) lowest = scanned(i) < scanned(lowest) ? i : lowest;
  if (scanned(lowest) > sag) return;
  // Every point that is deeper than its neighbours: a leaning peg touches the mouth on both sides.
  minimum(lowest);
  for (int i = 0; i < kScan; ++i) {
    const bool hollow = scanned(i) < scanned(i - 1) - kProminent && scanned(i) < scanned(i + 1) - kProminent;
    if (i != lowest && hollow && scanned(i) < sag) minimum(i);
  }
  for (int i = 1; i < kSpread; ++i) {
    const double angle = angles[0] + kTurn * i / kSpread;
    const auto same = [&](double one) { return std::abs(std::remainder(one - angle, kTurn)) < kNear; };
    if (std::none_of(angles.begin(), angles.begin() + static_cast<std::ptrdiff_t>(used), same)) angles[used++] = angle;
  }
  const std::size_t first = count_;
  for (std::size_t i = 0; i < used; ++i) {
    const Vector3d p = circle.at(angles[i]);
    const SurfacePoint surface = other.nearest(p);
    // Friction of the two halves is remembered apart where faces are steep: opposite points have no normal in common.
    const double upright = std::abs(surface.normal.dot(circle.u.cross(circle.v)) / circle.u.squaredNorm());
    const bool half = upright < kSteep && std::sin(angles[i] - kHalves) < 0.0;
    if (surface.distance < 0.0) emit(side, p, surface, 2 * feature + (half ? 1 : 0));
  }
  weigh(first);
}

/// The deepest point between the ends; the ends are corners.
void Touches::segment(const Side& side, const Vector3d& from, const Vector3d& to, int feature) {
  const SolidView& other = side.surface;
  const Vector3d along = to - from;
  if (other.nearest(0.5 * (from + to)).distance > 0.5 * along.norm()) return;
  std::array<double, kEdgeScan + 1> distance{};
  std::size_t lowest = 0;
  for (std::size_t i = 0; i <= kEdgeScan; ++i) {
    distance[i] = other.nearest(from + static_cast<double>(i) / kEdgeScan * along).distance;
    if (distance[i] < distance[lowest]) lowest = i;
  }
  const auto slope = [&](double share) { return other.nearest(from + share * along).normal.dot(along); };
  const double begin = static_cast<double>(lowest > 0 ? lowest - 1 : 0) / kEdgeScan;
  const double end = static_cast<double>(std::min<std::size_t>(lowest + 1, kEdgeScan)) / kEdgeScan;
  const double share = deepest(begin, end, slope);
  const Vector3d p = from + share * along;
  const SurfacePoint surface = other.nearest(p);
  const double ends = std::min(distance.front(), distance.back());
  const std::size_t first = count_;
  if (surface.distance < 0.0 && surface.distance < ends - kProminent) emit(side, p, surface, 2 * feature);
  weigh(first);
}

void Touches::rims(const Side& side, int& feature) {
  if (!side.edges.solid) return;
  for (const DrilledBore& bore : side.edges.solid->bores) {
    const Pose X_WB = side.edges.X_W * bore.X_GB;
    const auto rim = [&](double radius, double z) {
      circle(side, {X_WB * Vector3d(0, 0, z), radius * X_WB.linear().col(0), radius * X_WB.linear().col(1)}, feature++);
    };
    rim(bore.radius + bore.chamfer, 0.0);
    if (bore.chamfer > 0.0) rim(bore.radius, -bore.chamfer);
    if (!bore.through) continue;
    rim(bore.radius + bore.chamfer, -bore.length);
    if (bore.chamfer > 0.0) rim(bore.radius, bore.chamfer - bore.length);
  }
}

void Touches::features(const Side& side) {
  const SolidView& view = side.edges;
  int feature = 0;
  const auto at = [&](double x, double y, double z) -> Vector3d { return view.X_W * Vector3d(x, y, z); };
  switch (view.shape) {
    case SolidView::Shape::kPlane:
      break;
    case SolidView::Shape::kSphere:
      ball(side, view.X_W.translation(), view.size[0], feature++);
      break;
    case SolidView::Shape::kCapsule:
      for (const double end : {-view.size[1], view.size[1]}) ball(side, at(0, 0, end), view.size[0], feature++);
      break;
    case SolidView::Shape::kCylinder: {
      const double r = view.size[0], h = view.size[1], c = view.solid ? view.solid->chamfer : 0.0;
      const auto rim = [&](double radius, double z) {
        circle(side, {at(0, 0, z), radius * view.X_W.linear().col(0), radius * view.X_W.linear().col(1)}, feature++);
      };
      for (const double end : {-1.0, 1.0}) {
        rim(r - c, end * h);
        if (c > 0.0) rim(r, end * (h - c));
      }
      break;
    }
    case SolidView::Shape::kBox:
      for (int i = 0; i < 8; ++i) {
        const Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
        const Vector3d from = view.X_W * sign.cwiseProduct(view.size);
        corner(side, from, feature++);
        for (int axis = 0; axis < 3; ++axis) {
          if (sign[axis] > 0.0) continue;
          segment(side, from, from + 2.0 * view.size[axis] * view.X_W.linear().col(axis), feature++);
        }
      }
      break;
    case SolidView::Shape::kMesh:
      for (const Vector3d& vertex : view.hull->vertices) corner(side, view.X_W * vertex, feature++);
      break;
  }
  rims(side, feature);
}

void Touches::find(const SolidView& first, const SolidView& second) {
  const SolidView& drilled = first.drilled() ? first : second;
  features({first, second, true, drilled});
  features({second, first, false, drilled});
}

void Touches::find_rims(const SolidView& first, const SolidView& second) {
  const SolidView& drilled = first.drilled() ? first : second;
  int feature = 0;
  rims({first, second, true, drilled}, feature);
  feature = 0;
  rims({second, first, false, drilled}, feature);
}

void Touches::keep_bottoms(const SolidView& first, const SolidView& second) {
  const SolidView& drilled = first.drilled() ? first : second;
  const auto elsewhere = [&](const Touch& touch) {
    return touch.group >= kFlatGroups || !is_at_bottom(drilled, touch.position);
  };
  const auto end = std::remove_if(touches_.begin(), touches_.begin() + static_cast<std::ptrdiff_t>(count_), elsewhere);
  count_ = static_cast<std::size_t>(end - touches_.begin());
}

/// By insertion: there are few, and nothing may be allocated.
void Touches::sort() {
  for (std::size_t i = 1; i < count_; ++i) {
    const Touch touch = touches_[i];
    std::size_t k = i;
    for (; k > 0 && touches_[k - 1].group > touch.group; --k) touches_[k] = touches_[k - 1];
    touches_[k] = touch;
  }
}

// -- Where the bores are ----------------------------------------------------------------------------------------------

bool reaches_bore(const SolidView& drilled, const SolidView& other) {
  if (!drilled.solid) return false;
  for (const DrilledBore& bore : drilled.solid->bores) {
    const Pose X_WB = drilled.X_W * bore.X_GB;
    const double radius = bore.radius + bore.chamfer;
    const double far = (other.X_W.translation() - X_WB.translation()).norm() - other.bound - bore.length - radius;
    if (other.bound > 0.0 && far > 0.0) continue;
    const int pieces = std::clamp(static_cast<int>(std::ceil(bore.length / radius)), 1, 8);
    for (int i = 0; i <= pieces; ++i) {
      const double z = -bore.length * i / pieces;
      const double distance = other.nearest(X_WB * Vector3d(0, 0, z)).distance;
      if (distance <= radius + 0.5 * bore.length / pieces) return true;
    }
  }
  return false;
}

bool over_bore(const SolidView& drilled, const Vector3d& p_W) {
  if (!drilled.solid) return false;
  const Vector3d p_G = drilled.X_W.inverse(Eigen::Isometry) * p_W;
  return std::ranges::any_of(drilled.solid->bores, [&](const DrilledBore& bore) {
    const Vector3d p = bore.X_GB.inverse(Eigen::Isometry) * p_G;
    return p.head<2>().norm() < bore.radius + bore.chamfer && p.z() > -bore.length - kDeep;
  });
}

bool is_at_bottom(const SolidView& drilled, const Vector3d& p_W) {
  const Vector3d p_G = drilled.X_W.inverse(Eigen::Isometry) * p_W;
  return std::ranges::any_of(drilled.solid->bores, [&](const DrilledBore& bore) {
    const Vector3d p = bore.X_GB.inverse(Eigen::Isometry) * p_G;
    return !bore.through && p.head<2>().norm() < bore.radius + bore.chamfer && std::abs(p.z() + bore.length) < kDeep &&
           p.z() < -0.5 * bore.length;
  });
}

bool is_in_bore(const SolidView& drilled, const SolidView& other) {
  if (!drilled.solid) return false;
  for (const DrilledBore& bore : drilled.solid->bores) {
    const Pose X_WB = drilled.X_W * bore.X_GB;
    const double deep = std::min(kDeep, 0.25 * bore.length);
    const auto inside = [&](double radius, double angle, double z) {
      const Vector3d p = X_WB * Vector3d(radius * std::cos(angle), radius * std::sin(angle), z);
      return other.nearest_of_shape(other.X_W.inverse(Eigen::Isometry) * p).distance < 0.0;
    };
    for (int end = 0; end < (bore.through ? 2 : 1); ++end) {
      const double z = end == 0 ? -deep : deep - bore.length;
      if (inside(0.0, 0.0, z)) return true;
      for (int i = 0; i < kSpread; ++i) {
        if (inside(0.5 * bore.radius, kTurn * i / kSpread, z) || inside(0.98 * bore.radius, kTurn * i / kSpread, z))
          return true;
      }
    }
  }
  return false;
}

}  // namespace takt::sim
