#pragma once

#include <mujoco/mujoco.h>
#include <Eigen/Core>

namespace takt::sim {

/// Adds to what is applied to a body in this physics step, which begins with what World::push() applies: N and Nm in
/// the world, the force at its centre of mass. Realtime: cyclic.
inline void add_wrench(mjData& data, int body, const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
  Eigen::Map<Eigen::Vector3d>(data.xfrc_applied + 6 * body) += force;
  Eigen::Map<Eigen::Vector3d>(data.xfrc_applied + 6 * body + 3) += torque;
}

/// The same for a force at a point of the world, m.
inline void add_force(mjData& data, int body, const Eigen::Vector3d& force, const Eigen::Vector3d& point) {
  const Eigen::Vector3d arm = point - Eigen::Map<const Eigen::Vector3d>(data.xipos + 3 * body);
  add_wrench(data, body, force, arm.cross(force));
}

}  // namespace takt::sim
