#pragma once

#include <Eigen/Core>

struct mjData_;

namespace takt::sim {

/// Adds to what is applied to a body in this physics step, which begins with what World::push() applies: N and Nm in
/// the world, the force at its centre of mass. Realtime: cyclic.
void add_wrench(mjData_& data, int body, const Eigen::Vector3d& force, const Eigen::Vector3d& torque);
/// The same for a force at a point of the world, m. Realtime: cyclic.
void add_force(mjData_& data, int body, const Eigen::Vector3d& force, const Eigen::Vector3d& point);

}  // namespace takt::sim
