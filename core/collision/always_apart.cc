#include "core/collision/always_apart.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "core/collision/narrow_phase.h"

namespace takt::collision {
namespace {

/// Postures that are looked at before it is given up.
constexpr int kMostLooks = 3'000;
/// Corners of the polygons that hold the circles of what is turned.
constexpr int kRing = 24;

/// Corner i of a polygon around a circle of radius 1.
Eigen::Vector2d on_ring(int i) {
  const double angle = 2.0 * std::numbers::pi * i / kRing, wider = 1.0 / std::cos(std::numbers::pi / kRing);
  return wider * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

/// Points whose hull holds a part, in the frame of its body.
std::vector<Eigen::Vector3d> corners_of(const Part& part) {
  std::vector<Eigen::Vector3d> corners;
  const Eigen::Vector3d& half = part.solid.half();
  switch (part.solid.kind()) {
    case Convex::Kind::kHull:
      corners.assign(part.solid.corners().begin(), part.solid.corners().end());
      break;
    case Convex::Kind::kCylinder:
      for (int i = 0; i < kRing; ++i)
        for (const double z : {-half.z(), half.z()})
          corners.emplace_back(half.x() * on_ring(i).x(), half.x() * on_ring(i).y(), z);
      break;
    default:
      for (int i = 0; i < 8; ++i)
        corners.push_back(part.solid.box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  }
  for (Eigen::Vector3d& corner : corners) corner = part.X_BS * corner;
  return corners;
}

/// Heights along an axis and distances from it, as far out as any: of a convex solid the others are within.
using Profile = std::vector<Eigen::Vector2d>;
Profile outline(Profile points) {
  std::ranges::sort(points,
                    [](const auto& a, const auto& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); });
  Profile outer;
  for (const Eigen::Vector2d& p : points) {
    while (outer.size() > 1) {
      const Eigen::Vector2d side = outer.back() - outer[outer.size() - 2], next = p - outer.back();
      if (side.x() * next.y() - side.y() * next.x() < 0.0) break;  // it bends inwards
      outer.pop_back();
    }
    outer.push_back(p);
  }
  return outer;
}

/// A convex solid that holds all that a part sweeps in a whole turn about an axis through the origin of its frame.
std::optional<Part> turned(const Part& part, const Eigen::Vector3d& axis) {
  Profile profile;
  for (const Eigen::Vector3d& p : corners_of(part)) profile.emplace_back(axis.dot(p), axis.cross(p).norm());
  const Eigen::Vector3d across = axis.unitOrthogonal(), other = axis.cross(across);
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector2d& p : outline(std::move(profile))) {
    for (int i = 0; i < kRing; ++i)
      points.push_back(p.x() * axis + p.y() * (on_ring(i).x() * across + on_ring(i).y() * other));
  }
  auto solid = Convex::hull(points);
  if (!solid) return std::nullopt;
  return Part{.solid = std::move(*solid), .X_BS = Eigen::Isometry3d::Identity()};
}

/// Two bodies with one joint between them. N: the frame that it turns, I: the inner body.
struct Hinge {
  const Body* inner = nullptr;
  std::vector<Part> outer = {};  ///< in N
  Eigen::Isometry3d X_IN = Eigen::Isometry3d::Identity();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  int joint = -1;
};

/// From the outer body to the one that the inner body carries; empty: it does not carry it.
std::vector<const Body*> chain_between(const Scene& scene, int inner, int outer) {
  std::vector<const Body*> chain;
  for (int at = outer; at != inner; at = scene.body(at).parent) {
    if (at < 0 || scene.body(at).root) return {};
    chain.push_back(&scene.body(at));
  }
  return chain;
}

/// The frame of chain[to] in that of what carries chain[from - 1], with all joints at zero.
Eigen::Isometry3d along(const std::vector<const Body*>& chain, std::size_t from, std::size_t to) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (std::size_t i = from; i > to; --i) X = X * chain[i - 1]->X_PJ;
  return X;
}

std::optional<Hinge> hinge_between(const Scene& scene, int inner, int outer) {
  const std::vector<const Body*> chain = chain_between(scene, inner, outer);
  std::vector<std::size_t> joints;
  for (std::size_t i = 0; i < chain.size(); ++i)
    if (chain[i]->joint >= 0) joints.push_back(i);
  if (joints.empty() || joints.size() > 2) return std::nullopt;
  if (std::ranges::any_of(joints, [&](std::size_t i) { return chain[i]->prismatic; })) return std::nullopt;
  Hinge hinge{.inner = &scene.body(inner), .outer = scene.body(outer).parts};
  const auto place = [&hinge](const Eigen::Isometry3d& X) {
    for (Part& part : hinge.outer) part.X_BS = X * part.X_BS;
  };
  place(along(chain, joints.front(), 0));
  if (joints.size() == 2) {
    for (Part& part : hinge.outer) {
      auto whole = turned(part, chain[joints.front()]->axis);
      if (!whole) return std::nullopt;
      part = std::move(*whole);
    }
    place(along(chain, joints.back(), joints.front()));
  }
  hinge.X_IN = along(chain, chain.size(), joints.back());
  hinge.axis = chain[joints.back()]->axis;
  hinge.joint = chain[joints.back()]->joint;
  return hinge;
}

class Proof {
 public:
  Proof(const Hinge& hinge, double wanted) : hinge_(hinge), wanted_(wanted) {
    for (const Part& part : hinge.outer)
      for (const Eigen::Vector3d& p : corners_of(part)) lever_ = std::max(lever_, hinge.axis.cross(p).norm());
    hints_.assign(hinge.inner->parts.size() * hinge.outer.size(), Eigen::Vector3d::UnitX());
  }

  bool holds(double lower, double upper) {
    std::vector<Range> left{{0.5 * (lower + upper), 0.5 * (upper - lower)}};
    for (int looks = 0; !left.empty(); ++looks) {
      if (looks == kMostLooks) return false;
      const Range range = left.back();
      left.pop_back();
      const double enough = wanted_ + lever_ * range.half, apart = distance_at(range.middle, enough);
      if (apart >= enough) continue;
      if (apart < wanted_) return false;
      for (const double side : {-0.5, 0.5}) left.push_back({range.middle + side * range.half, 0.5 * range.half});
    }
    return true;
  }

 private:
  struct Range {
    double middle, half;  ///< rad
  };

  /// m, from below
  double distance_at(double q, double enough) {
    const Eigen::Isometry3d X_IN = hinge_.X_IN * Eigen::AngleAxisd(q, hinge_.axis);
    double least = enough;
    std::size_t at = 0;
    for (const Part& inner : hinge_.inner->parts) {
      const Eigen::Isometry3d X_SN = inner.X_BS.inverse() * X_IN;
      for (const Part& outer : hinge_.outer) {
        Eigen::Vector3d& hint = hints_[at++];
        const Separation parted =
            separation(inner.solid, outer.solid, X_SN * outer.X_BS, hint, least, Effort::kThorough);
        hint = parted.axis_A;
        least = std::min(least, parted.distance);
      }
    }
    return least;
  }

  const Hinge& hinge_;
  double wanted_;
  double lever_ = 0.0;  ///< m: how far a point of the outer body can be from the axis
  std::vector<Eigen::Vector3d> hints_;
};

}  // namespace

bool always_apart(const Scene& scene, int a, int b, std::span<const double> lower, std::span<const double> upper,
                  double wanted) {
  for (const auto& [inner, outer] : {std::pair(a, b), std::pair(b, a)}) {
    const auto hinge = hinge_between(scene, inner, outer);
    if (!hinge) continue;
    const auto j = static_cast<std::size_t>(hinge->joint);
    return Proof(*hinge, wanted).holds(lower[j], upper[j]);
  }
  return false;
}

}  // namespace takt::collision
