#pragma once

#include <limits>
#include <string>

#include <Eigen/Geometry>

#include "core/world/revolved.h"

namespace takt::world {

/// A round hole in a flat face of a box or cylinder, perpendicular to it. Its frame B is at the middle of its mouth, z
/// out of the material; the hole goes along -z. Lengths in m.
struct Bore {
  static constexpr double kThrough = std::numeric_limits<double>::infinity();

  Eigen::Isometry3d X_SB = Eigen::Isometry3d::Identity();  ///< in the frame of the shape
  double radius = 0.0;                                     ///< of the wall; of a thread: its minor radius
  double depth = kThrough;                                 ///< to the flat bottom
  double chamfer = 0.0;                                    ///< width and depth of the 45 degree chamfer at each mouth
  std::string thread = {};                                 ///< size of its thread ("M6"); empty: smooth

  [[nodiscard]] bool through() const { return depth == kThrough; }
};

/// The material around a bore as if the face went on for ever, in B. @param thickness  m, of the part below the mouth
[[nodiscard]] Revolved material_around(const Bore& bore, double thickness);

/// A cylinder about z, centred, with a 45 degree chamfer of this width at both ends (0: sharp edges).
[[nodiscard]] Revolved chamfered_cylinder(double radius, double length, double chamfer);

}  // namespace takt::world
