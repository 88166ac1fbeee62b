#pragma once

#include <string>

#include "sim/world/world.h"

namespace takt::sim::test {

/// Parts of a test cell: an LWR 4+ on a table, with force/torque sensor and ball probe, as the models folder has them.
/// The figures that are not in a URDF are written here again on purpose: these tests are about the simulation, not
/// about reading device files.
[[nodiscard]] std::shared_ptr<const kinematics::RobotModel> model(const std::string& name);
[[nodiscard]] kinematics::Chain lwr_chain();
[[nodiscard]] JointVector lwr_home();

[[nodiscard]] RobotDescription lwr();
[[nodiscard]] SimArmDescription lwr_controller();
/// Sensor and probe on the flange of the robot "arm", and the sensor device "wrist" without bias and noise.
void add_probe(WorldDescription& world);
/// A box fixed to the world.
[[nodiscard]] ObjectDescription box(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& at);

/// The world, or a failure of the test with all diagnostics.
[[nodiscard]] World make(const WorldDescription& description);

/// Steps with the set point q (and rates) for that many cycles; fails the test if the physics diverges.
void hold(World& world, const JointVector& q, int cycles);
[[nodiscard]] device::ArmSetPoint set_point(const JointVector& q, const JointVector& dq, const JointVector& ddq);
[[nodiscard]] device::ArmSetPoint set_point(const JointVector& q);
[[nodiscard]] device::ArmSample sample(World& world);
[[nodiscard]] device::WrenchSample wrench(World& world);

}  // namespace takt::sim::test
