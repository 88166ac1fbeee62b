#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Geometry>

#include "sim/contact/solid_view.h"

namespace takt::sim {

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
  struct Side;
  void features(const Side& side);
  void rims(const Side& side, int& feature);
  void circle(const Side& side, const Pose& X_SC, double radius, int feature);
  void flat_circle(const Side& side, const NearSurface& near, const EdgeCircle& ring, const Eigen::Vector3d& normal,
                   int feature);
  void segment(const Side& side, const Eigen::Vector3d& from, const Eigen::Vector3d& to, int feature);
  void corner(const Side& side, const Eigen::Vector3d& p, int feature);
  void ball(const Side& side, const Eigen::Vector3d& centre, double radius, int feature);
  void emit(const Side& side, const Eigen::Vector3d& p, const world::SurfacePoint& surface, int feature);
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
