#include "sim/contact/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

namespace takt::sim {
namespace {

/// So far in front of what it has met its middle is put, in its radii: deep enough that the contact is found.
constexpr double kInFront = 0.9;
constexpr int kMostSurfaces = 8;  // that a ray passes through, as they are open

/// Half of the smallest extent of a shape.
double smallest_radius(const mjModel& model, int geom) {
  const double* size = model.geom_size + 3 * geom;
  switch (model.geom_type[geom]) {
    case mjGEOM_SPHERE:
    case mjGEOM_CAPSULE:
      return size[0];
    case mjGEOM_CYLINDER:
      return std::min(size[0], size[1]);
    case mjGEOM_BOX:
    case mjGEOM_ELLIPSOID:
      return std::min({size[0], size[1], size[2]});
    default: {  // a mesh: of the box around it
      const double* box = model.geom_aabb + 6 * geom + 3;
      return std::min({box[0], box[1], box[2]});
    }
  }
}

/// By how much a point of the surface of a shape moves in a step, m.
Eigen::Vector3d moves(const mjModel& model, const mjData& data, int geom, const Eigen::Vector3d& point) {
  const int body = model.geom_bodyid[geom];
  std::array<double, 6> velocity{};
  mj_objectVelocity(&model, &data, mjOBJ_BODY, body, velocity.data(), 0);
  const Eigen::Map<const Eigen::Vector3d> angular(velocity.data()), linear(velocity.data() + 3);
  const Eigen::Map<const Eigen::Vector3d> middle(data.xipos + 3 * body);
  return model.opt.timestep * (linear + angular.cross(point - middle));
}

}  // namespace

Sweep::Sweep(const mjModel& model, std::vector<bool> open) : open_(std::move(open)) {
  for (int joint = 0; joint < static_cast<int>(model.njnt); ++joint) {
    const int body = model.jnt_bodyid[joint];
    if (model.jnt_type[joint] != mjJNT_FREE || model.body_geomnum[body] == 0) continue;
    Flyer flyer{.body = body, .position = model.jnt_qposadr[joint], .velocity = model.jnt_dofadr[joint]};
    for (int i = 0; i < model.body_geomnum[body]; ++i)
      flyer.radius = std::max(flyer.radius, smallest_radius(model, model.body_geomadr[body] + i));
    flyer.p_BC = Eigen::Map<const Eigen::Vector3d>(model.body_ipos + 3 * body);
    flyers_.push_back(flyer);
  }
}

void Sweep::stop(const mjModel& model, mjData& data) const {
  for (const Flyer& flyer : flyers_) {
    const double way = model.opt.timestep * Eigen::Map<const Eigen::Vector3d>(data.qvel + flyer.velocity).norm();
    if (way <= flyer.radius) continue;
    const double* q = data.qpos + flyer.position + 3;
    Eigen::Map<Eigen::Vector3d> p_WB(data.qpos + flyer.position);
    const Eigen::Vector3d end = p_WB + Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * flyer.p_BC;
    Eigen::Vector3d from = Eigen::Map<const Eigen::Vector3d>(data.xipos + 3 * flyer.body);
    const double length = (end - from).norm();
    if (!(length > flyer.radius) || !std::isfinite(length)) continue;
    const Eigen::Vector3d along = (end - from) / length;
    double gone = 0.0;
    for (int i = 0; i < kMostSurfaces; ++i) {
      int geom = -1;
      const double distance = mj_ray(&model, &data, from.data(), along.data(), nullptr, 1, flyer.body, &geom, nullptr);
      if (distance < 0.0 || gone + distance >= length) break;
      gone += distance;
      // What moves along with it is no wall.
      const double ahead = moves(model, data, geom, from + distance * along).dot(along);
      const double beyond = length - gone - ahead;
      if (beyond > 0.0 && model.geom_contype[geom] != 0 && !open_[static_cast<std::size_t>(geom)]) {
        p_WB -= (beyond + kInFront * flyer.radius) * along;
        break;
      }
      constexpr double kBeyond = 1e-6;  // m
      gone += kBeyond;
      from += (distance + kBeyond) * along;
    }
  }
}

}  // namespace takt::sim
