#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
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
  /// A set of lines of the outline, a bit for each.
  using Lines = std::uint8_t;
  static constexpr Lines kAllLines = 0xff;

  Revolved() = default;
  /// Points that coincide with the one before are left out. At most kPoints.
  Revolved(std::initializer_list<Point> outline);

  /// The nearest point of the surface, exact on both sides. @param p  m, in the frame of the axis
  /// @param lines  those that count: all, or what lines_near() says of a region with p in it
  [[nodiscard]] SurfacePoint nearest(const Eigen::Vector3d& p, Lines lines = kAllLines) const;
  /// Its distance alone, m.
  [[nodiscard]] double distance(const Eigen::Vector3d& p, Lines lines = kAllLines) const;
  [[nodiscard]] double distance(const Point& at, Lines lines = kAllLines) const;
  /// Those that can be nearest to a point of the half plane within `radius` of `at`, m.
  [[nodiscard]] Lines lines_near(const Point& at, double radius) const;
  /// Where the only one of these lines is a plane face: its normal along the axis, 1 or -1; else 0.
  [[nodiscard]] double plane(Lines lines) const;

 private:
  struct Line {
    Eigen::Vector2d from, along, normal;  ///< its beginning; unit vectors
    double length = 0.0;                  ///< m
  };
  /// The nearest point of the lines.
  struct Nearest {
    std::size_t line = 0;
    double along = 0.0;    ///< m, on that line, from its beginning
    double aside = 0.0;    ///< m, from the line, to the free side
    double squared = 0.0;  ///< of the distance
    int corner = 0;        ///< -1, 1: it is the beginning or the end of the line, and another line goes on there
  };
  [[nodiscard]] Nearest nearest_line(const Eigen::Vector2d& at, Lines lines) const;
  [[nodiscard]] bool is_free(const Nearest& found) const;

  std::array<Line, kPoints - 1> lines_{};
  std::array<Eigen::Vector2d, kPoints> corner_normals_{};  ///< at the beginning of each line: sum of the two normals
  std::size_t count_ = 0;                                  ///< of lines
};

}  // namespace takt::world
