// Cameras that stand free in the room.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "sim/film/renderer.h"

namespace takt::sim {
namespace {

bool is_seen(const mjModel* model, int geom) {
  const int material = model->geom_matid[geom];
  return material >= 0 ? model->mat_rgba[4 * material + 3] > 0 : model->geom_rgba[4 * geom + 3] > 0;
}

/// What is drawn of the model's geoms, as a box in the world; an endless floor has no place in it.
Eigen::AlignedBox3d drawn_box(const mjModel* model, const mjData* posed) {
  Eigen::AlignedBox3d box;
  for (int i = 0; i < model->ngeom; ++i) {
    if (model->geom_group[i] > 2 || model->geom_type[i] == mjGEOM_PLANE || !is_seen(model, i)) continue;
    const Eigen::Map<const Eigen::Vector3d> centre(model->geom_aabb + 6 * i), half(model->geom_aabb + 6 * i + 3);
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(posed->geom_xmat + 9 * i);
    const Eigen::Vector3d at = Eigen::Map<const Eigen::Vector3d>(posed->geom_xpos + 3 * i) + R * centre;
    const Eigen::Vector3d reach = R.cwiseAbs() * half;
    box.extend(Eigen::AlignedBox3d(at - reach, at + reach));
  }
  return box;
}

/// Along which a camera of this azimuth and elevation looks (MuJoCo's convention).
Eigen::Vector3d forward_of(const FreeCamera& camera) {
  const double azimuth = camera.azimuth * std::numbers::pi / 180, elevation = camera.elevation * std::numbers::pi / 180;
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

/// How far back a camera has to stand so that a point, seen from the box's centre, is inside of the picture: the point
/// is as far sideways as the picture is wide at its depth.
double distance_for(const Eigen::Vector3d& point, const FreeCamera& camera, double aspect, double tangent) {
  const Eigen::Vector3d forward = forward_of(camera);
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  const Eigen::Vector3d up = right.cross(forward);
  const double sideways = std::max(std::abs(point.dot(up)) / tangent, std::abs(point.dot(right)) / (tangent * aspect));
  return sideways - point.dot(forward);
}

}  // namespace

FreeCamera fitting_camera(const mjModel_* model, const mjData_* posed, double aspect) {
  constexpr double kMargin = 1.25;  // strips of text lie over both edges
  const Eigen::AlignedBox3d box = drawn_box(model, posed);
  FreeCamera camera = overview_camera(model);
  if (box.isEmpty()) return camera;
  const Eigen::Vector3d centre = box.center();
  std::copy_n(centre.data(), 3, camera.look_at.begin());
  const double tangent = std::tan(model->vis.global.fovy * std::numbers::pi / 360);
  double distance = 0.1;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d at = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    distance = std::max(distance, distance_for(at - centre, camera, aspect, tangent / kMargin));
  }
  camera.distance = distance;
  return camera;
}

FreeCamera camera_from(const std::array<double, 3>& eye, const std::array<double, 3>& target) {
  const Eigen::Vector3d along = Eigen::Vector3d(target.data()) - Eigen::Vector3d(eye.data());
  FreeCamera camera;
  camera.look_at = target;
  camera.distance = along.norm();
  camera.azimuth = std::atan2(along.y(), along.x()) * 180 / std::numbers::pi;
  camera.elevation = std::asin(std::clamp(along.z() / along.norm(), -1.0, 1.0)) * 180 / std::numbers::pi;
  return camera;
}

}  // namespace takt::sim
