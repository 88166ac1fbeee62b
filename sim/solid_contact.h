#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Geometry>

#include "core/world/revolved.h"
#include "sim/solids.h"

namespace takt::sim {

/// A geom at one moment, with the exact distance to its surface. Realtime: cyclic.
struct SolidView {
  enum class Shape : std::uint8_t { kPlane, kSphere, kCapsule, kCylinder, kBox, kMesh };

  Shape shape = Shape::kBox;
  Pose X_W = Pose::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< as MuJoCo has it: half lengths, radius and half length
  double bound = 0.0;                              ///< radius of a ball about it, m
  const Solid* solid = nullptr;
  const MeshHull* hull = nullptr;
  world::Revolved outline;  ///< of a cylinder

  /// Surface of the whole solid, bores included; point and normal in the world.
  [[nodiscard]] world::SurfacePoint nearest(const Eigen::Vector3d& p_W) const;
  /// Surface of the convex shape, bores filled; in the frame of the geom.
  [[nodiscard]] world::SurfacePoint nearest_of_shape(const Eigen::Vector3d& p_G) const;
  /// Direction of the axis of the bore nearest to a point, in the world; only of a drilled solid.
  [[nodiscard]] Eigen::Vector3d axis_near(const Eigen::Vector3d& p_W) const;
  [[nodiscard]] bool drilled() const { return solid && !solid->bores.empty(); }
  /// Bounded by planes, so that its corners and edges say where it touches.
  [[nodiscard]] bool has_corners() const { return shape == Shape::kBox || shape == Shape::kMesh; }
};

/// The contacts of two solids: points of the edges of each against the surface of the other. Fixed capacity; what does
/// not fit is dropped. Realtime: cyclic.
class Touches {
 public:
  static constexpr std::size_t kCapacity = 50;

  /// One of the two has a bore, and not both are bounded by planes.
  void find(const SolidView& first, const SolidView& second);
  /// Edges of the bores only.
  void find_rims(const SolidView& first, const SolidView& second);
  void add(const Touch& touch);
  /// The number of the spring of contacts on plane faces with this normal.
  [[nodiscard]] static std::uint8_t flat_group(const SolidView& drilled, const Eigen::Vector3d& normal);
  /// Only those on the flat bottoms of bores: for a screw and its own thread.
  void keep_bottoms(const SolidView& first, const SolidView& second);
  /// Those of one spring side by side.
  void sort();
  [[nodiscard]] std::span<const Touch> all() const { return {touches_.data(), count_}; }

 private:
  struct Circle;
  struct Side;
  void features(const Side& side);
  void rims(const Side& side, int& feature);
  void circle(const Side& side, const Circle& circle, int feature);
  void segment(const Side& side, const Eigen::Vector3d& from, const Eigen::Vector3d& to, int feature);
  void corner(const Side& side, const Eigen::Vector3d& p_W, int feature);
  void ball(const Side& side, const Eigen::Vector3d& centre, double radius, int feature);
  void emit(const Side& side, const Eigen::Vector3d& p_W, const world::SurfacePoint& surface, int feature);
  void weigh(std::size_t first);

  std::array<Touch, kCapacity> touches_;
  std::size_t count_ = 0;
};

/// Whether one solid comes into a bore of the other. Never says no wrongly. Realtime: cyclic.
[[nodiscard]] bool reaches_bore(const SolidView& drilled, const SolidView& other);
/// Whether a solid bounded by planes is deeper in a bore than contacts on the face around it explain.
[[nodiscard]] bool is_in_bore(const SolidView& drilled, const SolidView& other);
/// Whether a point lies on the bottom of a blind bore.
[[nodiscard]] bool is_at_bottom(const SolidView& drilled, const Eigen::Vector3d& p_W);
/// Whether a point lies over or in a bore.
[[nodiscard]] bool over_bore(const SolidView& drilled, const Eigen::Vector3d& p_W);

}  // namespace takt::sim
