#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include "core/world/revolved.h"
#include "sim/model/solids.h"

namespace takt::sim {

/// A geom at one moment, with the exact distance to its surface. G: frame of the geom. Realtime: cyclic.
struct SolidView {
  enum class Shape : std::uint8_t { kPlane, kSphere, kCapsule, kCylinder, kBox, kMesh };

  Shape shape = Shape::kBox;
  Pose X_W = Pose::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< as MuJoCo has it: half lengths, radius and half length
  double bound = 0.0;                              ///< radius of a ball about it, m; 0: it has no end
  const Solid* solid = nullptr;
  const MeshHull* hull = nullptr;
  const world::Revolved* outline = nullptr;  ///< of a cylinder

  [[nodiscard]] Eigen::Vector3d to_geom(const Eigen::Vector3d& p_W) const {
    return X_W.linear().transpose() * (p_W - X_W.translation());
  }
  /// Surface of the whole solid, bores included.
  [[nodiscard]] world::SurfacePoint nearest_in_geom(const Eigen::Vector3d& p_G) const;
  [[nodiscard]] double distance_in_geom(const Eigen::Vector3d& p_G) const;
  /// Surface of the convex shape, bores filled.
  [[nodiscard]] world::SurfacePoint nearest_of_shape(const Eigen::Vector3d& p_G) const;
  [[nodiscard]] double distance_of_shape(const Eigen::Vector3d& p_G) const;
  /// Direction of the axis of the bore nearest to a point, in G; only of a drilled solid.
  [[nodiscard]] Eigen::Vector3d axis_near(const Eigen::Vector3d& p_G) const;
  [[nodiscard]] bool drilled() const { return solid && !solid->bores.empty(); }
  /// Bounded by planes, so that its corners and edges say where it touches.
  [[nodiscard]] bool has_corners() const { return shape == Shape::kBox || shape == Shape::kMesh; }
};

/// A circle in the frame of a geom.
struct EdgeCircle {
  Eigen::Vector3d centre, u, v;  ///< m; u and v across the axis, as long as the radius
  Eigen::Vector3d axis;          ///< unit
  double radius = 0.0;           ///< m

  [[nodiscard]] Eigen::Vector3d at(const Eigen::Vector2d& direction) const {
    return centre + direction.x() * u + direction.y() * v;
  }
  [[nodiscard]] Eigen::Vector3d along(const Eigen::Vector2d& direction) const {
    return direction.x() * v - direction.y() * u;
  }
};

/// The surface of a solid as points of one region can meet it, the frame being that of its geom. A distance changes by
/// no more than one moves: what the distance at the middle of the region says can be nowhere the nearest is left out,
/// and nothing else. Idea: docs/bores.md, "Less to look at". Realtime: cyclic.
class NearSurface {
 public:
  /// Points of a half plane (r, z).
  struct Disc {
    world::Revolved::Point middle;
    double radius = 0.0;  ///< m
  };

  /// All of it.
  explicit NearSurface(const SolidView& solid);
  /// For the points of a ball, or of a circle, that are points of the region of `wider` too.
  NearSurface(const NearSurface& wider, const Eigen::Vector3d& centre, double radius);
  NearSurface(const NearSurface& wider, const EdgeCircle& ring);

  /// No point of the region is in the material.
  [[nodiscard]] bool free() const { return least_ > 0.0; }
  [[nodiscard]] double distance(const Eigen::Vector3d& p_G) const;
  [[nodiscard]] world::SurfacePoint nearest(const Eigen::Vector3d& p_G) const;
  /// Where a plane face is what every point of a circle, whose points are all of the region, is nearest to: its unit
  /// normal out of the material.
  [[nodiscard]] std::optional<Eigen::Vector3d> plane_below(const EdgeCircle& ring) const;
  [[nodiscard]] const SolidView& solid() const { return *solid_; }

 private:
  /// What the solid is the common part of: its convex shape, the surroundings of a bore.
  struct Part {
    const DrilledBore* bore = nullptr;  ///< null: the shape
    world::Revolved::Lines lines = world::Revolved::kAllLines;
  };
  /// A solid with more bores than this is looked at as a whole.
  static constexpr std::size_t kParts = 24;

  template <class Region>
  void narrow(const NearSurface& wider, const Region& region);
  template <class Region>
  [[nodiscard]] const world::Revolved* outline_of(const Part& part, const Region& region, Disc& disc) const;

  const SolidView* solid_;
  std::array<Part, kParts> parts_;
  std::size_t count_ = 0;
  bool whole_ = false;  ///< all parts count
  double least_;        ///< m, below the distance of every point
};

}  // namespace takt::sim
