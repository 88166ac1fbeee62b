#include "sim/contact/body_force.h"

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

namespace takt::sim {

using Eigen::Vector3d;

void add_wrench(mjData& data, int body, const Vector3d& force, const Vector3d& torque) {
  Eigen::Map<Vector3d>(data.xfrc_applied + 6 * body) += force;
  Eigen::Map<Vector3d>(data.xfrc_applied + 6 * body + 3) += torque;
}

void add_force(mjData& data, int body, const Vector3d& force, const Vector3d& point) {
  const Vector3d arm = point - Eigen::Map<const Vector3d>(data.xipos + 3 * body);
  add_wrench(data, body, force, arm.cross(force));
}

}  // namespace takt::sim
