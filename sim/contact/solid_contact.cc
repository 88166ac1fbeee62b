#include "sim/contact/solid_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace takt::sim {
namespace {

using Eigen::Vector3d;
using world::SurfacePoint;

constexpr int kScan = 48;       // points of a circle that are looked at first
constexpr int kSpread = 8;      // points of a circle that may touch at once, evenly about the deepest
constexpr int kFlatSpread = 4;  // on a plane face, where springs at three or more even points bear like a whole circle
constexpr int kEdgeScan = 8;    // pieces of an edge
constexpr int kCoarse = 12;     // of them, at first
constexpr int kRefinements = 14;  // of a deepest point; the error falls as a square, to
constexpr double kConverged = 1e-13;
constexpr double kNear = 0.35;       // rad: nearer than this to a deepest point is the same contact
constexpr double kSteep = 0.5;       // of a normal along the axis of an edge
constexpr double kHalves = 1.0;      // rad: where the halves of an edge meet; not where symmetric contacts are
constexpr double kProminent = 1e-9;  // m: by which a deepest point beats its neighbours
constexpr double kDeep = 2e-3;       // m below the face: deeper than what rests on the face sinks in
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kFlatGroups = 7;  // numbers of springs on plane faces: below this

/// Unit vectors at even angles, that of number 0 along x.
template <int kCount>
std::array<Eigen::Vector2d, kCount> even_directions() {
  std::array<Eigen::Vector2d, kCount> made;
  for (int i = 0; i < kCount; ++i)
    made[static_cast<std::size_t>(i)] = {std::cos(kTurn * i / kCount), std::sin(kTurn * i / kCount)};
  return made;
}
const std::array<Eigen::Vector2d, kScan> kDirections = even_directions<kScan>();

Eigen::Vector2d direction_of(int i) { return kDirections[static_cast<std::size_t>((i + kScan) % kScan)]; }

/// Turned by the angle of another.
Eigen::Vector2d turned(const Eigen::Vector2d& direction, const Eigen::Vector2d& by) {
  return {direction.x() * by.x() - direction.y() * by.y(), direction.x() * by.y() + direction.y() * by.x()};
}

/// The same by the tangent of half an angle.
Eigen::Vector2d turned(const Eigen::Vector2d& direction, double half_tangent) {
  const double squared = half_tangent * half_tangent;
  return turned(direction, Eigen::Vector2d(1.0 - squared, 2.0 * half_tangent) / (1.0 + squared));
}

/// The deepest point between two that slope towards each other.
/// @param at     point of a parameter, with what it is a point of
/// @param slope  of the distance there, per unit of the parameter
template <class Slope>
double deepest(double low, double high, const Slope& slope) {
  double at_low = slope(low), at_high = slope(high);
  if (at_low >= 0.0) return low;
  if (at_high <= 0.0) return high;
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kRefinements; ++i) {
    // Illinois: a secant that halves the end which stays.
    const double last = best;
    best = (low * at_high - high * at_low) / (at_high - at_low);
    const double here = slope(best);
    if (here == 0.0 || std::abs(best - last) < kConverged) return best;
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

// -- Edges of one solid against the surface of the other --------------------------------------------------------------

/// Whose edges, against whose surface. S: the frame of the surface's geom, E: that of the edges'.
struct Touches::Side {
  Side(const SolidView& of, const SolidView& against, bool is_first, const SolidView& with_bore)
      : edges(of),
        surface(against),
        first(is_first),
        drilled(with_bore),
        X_SE(against.X_W.inverse(Eigen::Isometry) * of.X_W),
        near(of.bound > 0.0 ? NearSurface(NearSurface(against), X_SE.translation(), of.bound) : NearSurface(against)) {}

  const SolidView& edges;
  const SolidView& surface;
  bool first;  ///< the edges are those of the first solid
  const SolidView& drilled;
  Pose X_SE;
  NearSurface near;  ///< as the edges can meet it

  /// Nothing of the surface is as far from its middle. @param far  m, of the nearest point of an edge
  [[nodiscard]] bool beyond(double far) const { return surface.bound > 0.0 && far > surface.bound; }
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

/// @param p  on an edge, in S, as the surface's point and normal
void Touches::emit(const Side& side, const Vector3d& p, const SurfacePoint& surface, int feature) {
  constexpr int kFeatures = 60;
  const Pose& X_WS = side.surface.X_W;
  const Vector3d normal = X_WS.linear() * surface.normal;
  Touch touch;
  touch.depth = -surface.distance;
  touch.position = X_WS * p + 0.5 * touch.depth * normal;
  touch.normal = side.first ? Vector3d(-normal) : normal;
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

void Touches::corner(const Side& side, const Vector3d& p, int feature) {
  if (!side.beyond(p.norm()) && side.near.distance(p) < 0.0) emit(side, p, side.near.nearest(p), 2 * feature);
}

/// A ball touches a face at one point, and a bore around its axis at up to a whole circle. Edges are the other's to
/// find.
void Touches::ball(const Side& side, const Vector3d& centre, double radius, int feature) {
  const NearSurface near(side.near, centre, radius);
  if (near.free()) return;
  SurfacePoint surface = near.nearest(centre);
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
    const SurfacePoint here = near.nearest(p);
    if (here.distance < 0.0 && !here.flat) emit(side, p, here, 2 * feature);
  }
  weigh(first);
}

/// An edge of a solid of revolution. @param X_SC  its middle, z along the axis
void Touches::circle(const Side& side, const Pose& X_SC, double radius, int feature) {
  const EdgeCircle ring{.centre = X_SC.translation(),
                        .u = radius * X_SC.linear().col(0),
                        .v = radius * X_SC.linear().col(1),
                        .axis = X_SC.linear().col(2),
                        .radius = radius};
  const double up = ring.centre.dot(ring.axis), off = (ring.centre - up * ring.axis).norm();
  if (side.beyond(std::hypot(up, off - radius))) return;
  const NearSurface near(side.near, ring);
  if (near.free()) return;
  if (const auto normal = near.plane_below(ring)) return flat_circle(side, near, ring, *normal, feature);

  std::array<double, kScan> distance;
  const auto scan = [&](int i) {
    return distance[static_cast<std::size_t>(i)] = near.distance(ring.at(direction_of(i)));
  };
  const auto scanned = [&](int i) { return distance[static_cast<std::size_t>((i + kScan) % kScan)]; };
  // From one point to the next the distance falls by no more than this.
  const double sag = radius * kTurn / kScan;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kScan; i += kScan / kCoarse) least = std::min(least, scan(i));
  if (least > 0.5 * sag * kScan / kCoarse) return;
  for (int i = 0; i < kScan; ++i) {
    if (i % (kScan / kCoarse) != 0) scan(i);
  }
  const auto lowest = static_cast<int>(std::ranges::min_element(distance) - distance.begin());
  if (scanned(lowest) > sag) return;

  std::array<Eigen::Vector2d, kScan + kSpread> found;
  std::size_t used = 0;
  const auto minimum = [&](int i) {
    const auto slope = [&](double half_tangent) {
      const Eigen::Vector2d direction = turned(direction_of(i), half_tangent);
      return near.nearest(ring.at(direction)).normal.dot(ring.along(direction));
    };
    const double end = std::tan(0.5 * kTurn / kScan);
    const Eigen::Vector2d direction = turned(direction_of(i), deepest(-end, end, slope));
    found[used++] = near.distance(ring.at(direction)) > scanned(i) ? direction_of(i) : direction;
  };
  // Every point that is deeper than its neighbours: a leaning peg touches the mouth on both sides.
  minimum(lowest);
  for (int i = 0; i < kScan; ++i) {
    const bool hollow = scanned(i) < scanned(i - 1) - kProminent && scanned(i) < scanned(i + 1) - kProminent;
    if (i != lowest && hollow && scanned(i) < sag) minimum(i);
  }
  for (int i = 1; i < kSpread; ++i) {
    const Eigen::Vector2d direction = turned(found[0], direction_of(i * kScan / kSpread));
    const auto same = [&](const Eigen::Vector2d& one) { return one.dot(direction) > std::cos(kNear); };
    if (std::none_of(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(used), same)) found[used++] = direction;
  }
  const Eigen::Vector2d halves(std::cos(kHalves), std::sin(kHalves));
  const std::size_t first = count_;
  for (std::size_t i = 0; i < used; ++i) {
    const Vector3d p = ring.at(found[i]);
    const SurfacePoint surface = near.nearest(p);
    if (surface.distance >= 0.0) continue;
    // Friction of the two halves is remembered apart where faces are steep: opposite points have no normal in common.
    const bool steep = std::abs(surface.normal.dot(ring.axis)) < kSteep;
    const bool half = steep && found[i].y() * halves.x() - found[i].x() * halves.y() < 0.0;
    emit(side, p, surface, 2 * feature + (half ? 1 : 0));
  }
  weigh(first);
}

/// On a plane face the deepest point is where the circle leans to.
void Touches::flat_circle(const Side& side, const NearSurface& near, const EdgeCircle& ring, const Vector3d& normal,
                          int feature) {
  Eigen::Vector2d deepest(-normal.dot(ring.u), -normal.dot(ring.v));
  deepest = deepest.norm() > kProminent ? Eigen::Vector2d(deepest.normalized()) : direction_of(0);
  for (int i = 0; i < kFlatSpread; ++i) {
    const Vector3d p = ring.at(turned(deepest, direction_of(i * kScan / kFlatSpread)));
    const SurfacePoint surface = near.nearest(p);
    if (surface.distance >= 0.0) {
      if (i == 0) return;
      continue;
    }
    emit(side, p, surface, 2 * feature);
  }
}

/// The deepest point between the ends; the ends are corners.
void Touches::segment(const Side& side, const Vector3d& from, const Vector3d& to, int feature) {
  const Vector3d along = to - from;
  if (side.beyond((from - std::clamp(from.dot(along) / along.squaredNorm(), -1.0, 0.0) * along).norm())) return;
  const NearSurface near(side.near, 0.5 * (from + to), 0.5 * along.norm());
  if (near.free()) return;
  std::array<double, kEdgeScan + 1> distance{};
  std::size_t lowest = 0;
  for (std::size_t i = 0; i <= kEdgeScan; ++i) {
    distance[i] = near.distance(from + static_cast<double>(i) / kEdgeScan * along);
    if (distance[i] < distance[lowest]) lowest = i;
  }
  const auto slope = [&](double share) { return near.nearest(from + share * along).normal.dot(along); };
  const double begin = static_cast<double>(lowest > 0 ? lowest - 1 : 0) / kEdgeScan;
  const double end = static_cast<double>(std::min<std::size_t>(lowest + 1, kEdgeScan)) / kEdgeScan;
  const double share = deepest(begin, end, slope);
  const Vector3d p = from + share * along;
  const SurfacePoint surface = near.nearest(p);
  const double ends = std::min(distance.front(), distance.back());
  const std::size_t first = count_;
  if (surface.distance < 0.0 && surface.distance < ends - kProminent) emit(side, p, surface, 2 * feature);
  weigh(first);
}

void Touches::rims(const Side& side, int& feature) {
  if (!side.edges.solid) return;
  for (const DrilledBore& bore : side.edges.solid->bores) {
    const Pose X_SB = side.X_SE * bore.X_GB;
    const auto rim = [&](double radius, double z) {
      circle(side, X_SB * Eigen::Translation3d(0, 0, z), radius, feature++);
    };
    rim(bore.radius + bore.chamfer, 0.0);
    if (bore.chamfer > 0.0) rim(bore.radius, -bore.chamfer);
    if (!bore.through) continue;
    rim(bore.radius + bore.chamfer, -bore.length);
    if (bore.chamfer > 0.0) rim(bore.radius, bore.chamfer - bore.length);
  }
}

void Touches::features(const Side& side) {
  if (side.near.free()) return;
  const SolidView& view = side.edges;
  int feature = 0;
  const auto at = [&](double x, double y, double z) -> Vector3d { return side.X_SE * Vector3d(x, y, z); };
  switch (view.shape) {
    case SolidView::Shape::kPlane:
      break;
    case SolidView::Shape::kSphere:
      ball(side, side.X_SE.translation(), view.size[0], feature++);
      break;
    case SolidView::Shape::kCapsule:
      for (const double end : {-view.size[1], view.size[1]}) ball(side, at(0, 0, end), view.size[0], feature++);
      break;
    case SolidView::Shape::kCylinder: {
      const double r = view.size[0], h = view.size[1], c = view.solid ? view.solid->chamfer : 0.0;
      const auto rim = [&](double radius, double z) {
        circle(side, side.X_SE * Eigen::Translation3d(0, 0, z), radius, feature++);
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
        const Vector3d from = side.X_SE * sign.cwiseProduct(view.size);
        corner(side, from, feature++);
        for (int axis = 0; axis < 3; ++axis) {
          if (sign[axis] > 0.0) continue;
          segment(side, from, from + 2.0 * view.size[axis] * side.X_SE.linear().col(axis), feature++);
        }
      }
      break;
    case SolidView::Shape::kMesh:
      for (const Vector3d& vertex : view.hull->vertices) corner(side, side.X_SE * vertex, feature++);
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

namespace {

/// How far the middle of a solid is from the axis of a bore, from its mouth to its end, m, less the solid's own size:
/// no point of the solid is nearer. @param p_G  the middle, in the frame of the drilled geom
double least_to_axis(const DrilledBore& bore, const Vector3d& p_G, const SolidView& other) {
  if (other.bound <= 0.0) return 0.0;
  const Vector3d p = bore.X_BG * p_G;
  return (p - Vector3d(0, 0, std::clamp(p.z(), -bore.length, 0.0))).norm() - other.bound;
}

}  // namespace

bool reaches_bore(const SolidView& drilled, const SolidView& other) {
  if (!drilled.solid) return false;
  const Vector3d middle = drilled.to_geom(other.X_W.translation());
  for (const DrilledBore& bore : drilled.solid->bores) {
    const double radius = bore.radius + bore.chamfer;
    const int pieces = std::clamp(static_cast<int>(std::ceil(bore.length / radius)), 1, 8);
    const double near = radius + 0.5 * bore.length / pieces;
    if (least_to_axis(bore, middle, other) > near) continue;
    const Pose X_WB = drilled.X_W * bore.X_GB;
    for (int i = 0; i <= pieces; ++i) {
      const double z = -bore.length * i / pieces;
      if (other.distance_in_geom(other.to_geom(X_WB * Vector3d(0, 0, z))) <= near) return true;
    }
  }
  return false;
}

bool over_bore(const SolidView& drilled, const Vector3d& p_W) {
  if (!drilled.solid) return false;
  const Vector3d p_G = drilled.to_geom(p_W);
  return std::ranges::any_of(drilled.solid->bores, [&](const DrilledBore& bore) {
    const Vector3d p = bore.X_BG * p_G;
    return p.head<2>().norm() < bore.radius + bore.chamfer && p.z() > -bore.length - kDeep;
  });
}

bool is_at_bottom(const SolidView& drilled, const Vector3d& p_W) {
  const Vector3d p_G = drilled.to_geom(p_W);
  return std::ranges::any_of(drilled.solid->bores, [&](const DrilledBore& bore) {
    const Vector3d p = bore.X_BG * p_G;
    return !bore.through && p.head<2>().norm() < bore.radius + bore.chamfer && std::abs(p.z() + bore.length) < kDeep &&
           p.z() < -0.5 * bore.length;
  });
}

bool is_in_bore(const SolidView& drilled, const SolidView& other) {
  if (!drilled.solid) return false;
  const Vector3d middle = drilled.to_geom(other.X_W.translation());
  for (const DrilledBore& bore : drilled.solid->bores) {
    if (least_to_axis(bore, middle, other) > bore.radius) continue;
    const Pose X_OB = other.X_W.inverse(Eigen::Isometry) * drilled.X_W * bore.X_GB;
    const double deep = std::min(kDeep, 0.25 * bore.length);
    const auto inside = [&](double radius, int i, double z) {
      const Eigen::Vector2d across = radius * direction_of(i * kScan / kSpread);
      return other.distance_of_shape(X_OB * Vector3d(across.x(), across.y(), z)) < 0.0;
    };
    for (int end = 0; end < (bore.through ? 2 : 1); ++end) {
      const double z = end == 0 ? -deep : deep - bore.length;
      if (inside(0.0, 0, z)) return true;
      for (int i = 0; i < kSpread; ++i) {
        if (inside(0.5 * bore.radius, i, z) || inside(0.98 * bore.radius, i, z)) return true;
      }
    }
  }
  return false;
}

}  // namespace takt::sim
