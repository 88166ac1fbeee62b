#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>

#include <Eigen/Core>

namespace takt::world {

/// Where the surface of a solid is, seen from a point.
struct SurfacePoint {
  double distance = 0.0;                              ///< m; negative inside the material
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, out of the material, at the nearest point
  bool flat = false;                                  ///< the nearest point is inside a plane face
  bool edge = false;                                  ///< it is on an edge or corner
};

/// The surface of a solid of revolution about z, by its outline in the half plane (r, z), r >= 0. The outline is a
/// chain of straight lines; seen along it, the free side is on the right. It may begin or end far away, so a hole in a
/// large plate is one too. Realtime: cyclic but for the constructor.
class Revolved {
 public:
  struct Point {
    double r = 0.0, z = 0.0;  ///< m
  };
  static constexpr std::size_t kPoints = 8;

  Revolved() = default;
  /// Points that coincide with the one before are left out. At most kPoints.
  Revolved(std::initializer_list<Point> outline);

  /// The nearest point of the surface, exact on both sides. @param p  m, in the frame of the axis
  [[nodiscard]] SurfacePoint nearest(const Eigen::Vector3d& p) const;

 private:
  [[nodiscard]] Eigen::Vector2d normal(std::size_t line) const;

  std::array<Eigen::Vector2d, kPoints> points_{};
  std::size_t count_ = 0;
};

}  // namespace takt::world
