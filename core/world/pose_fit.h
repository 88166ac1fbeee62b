#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/diagnostics.h"
#include "core/world/object.h"

namespace takt::world {

/// One touch of an object: where the centre of the probe ball stood, in the reference frame R of the fit, m.
struct Contact {
  std::string name;
  Eigen::Vector3d p_R = Eigen::Vector3d::Zero();
  double radius = 0.0;  ///< of the ball, m
};

/// Coordinates of a pose that a fit may change: translation along x, y, z and rotation vector about x, y, z of frame R.
enum class Coordinate { kX, kY, kZ, kRoll, kPitch, kYaw };

struct PoseFit {
  Eigen::Isometry3d X_RO = Eigen::Isometry3d::Identity();
  double rms_residual = 0.0;  ///< of the distances surface to ball, m
  int iterations = 0;
};

/// Finds the pose of `object` in R whose surface touches every ball: least squares over the signed distances, by
/// Levenberg-Marquardt from the nominal pose. Coordinates that are not free keep their nominal value.
/// @return diagnostics if there are fewer contacts than free coordinates, if the contacts leave a coordinate
/// undetermined (named), or if the best residual is above `max_residual` (m). Realtime: setup.
[[nodiscard]] Result<PoseFit> fit_pose(const Object& object, const std::vector<Contact>& contacts,
                                       const Eigen::Isometry3d& X_RO_nominal, const std::vector<Coordinate>& free,
                                       double max_residual = 1e-3);

}  // namespace takt::world
