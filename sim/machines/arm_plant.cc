#include "sim/machines/arm_plant.h"

#include <algorithm>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "core/kinematics/chain.h"
#include "sim/machines/nominal_payload.h"
#include "sim/model/description_check.h"

namespace takt::sim {

Result<ArmPlant> arm_plant(const mjModel& model, const mjData& data, const WorldDescription& description,
                           const SimArmDescription& arm) {
  const auto& robot = *std::ranges::find(description.robots, arm.robot, &RobotDescription::name);
  const std::string at = place(arm.pointer, "arms", arm.name);
  std::span<const std::string> wheels;
  if (arm.drive) wheels = arm.drive->wheels;
  auto chain = kinematics::Chain::create(*robot.model, arm.base_link, arm.flange_link, wheels);
  if (!chain) {
    Diagnostics found;
    found.append(chain.error(), at);
    return std::unexpected(std::move(found));
  }
  const int n = chain->joint_count();
  Diagnostics wrong_sizes;
  for (const JointVector* given :
       {&arm.control.natural_frequency, &arm.control.damping_ratio, &arm.control.friction_observer,
        &arm.control.protective_torque, &arm.measurement.torque_noise, &arm.measurement.torque_bias}) {
    if (given->size() == 0 || given->size() == n) continue;
    wrong_sizes.error(Code::kWrongSize, at, fmt::format("{} figures for {} joints", given->size(), n),
                      "Give one for each joint, or none");
  }
  if (wrong_sizes.has_errors()) return std::unexpected(std::move(wrong_sizes));
  ArmPlant plant{.chain = std::move(*chain)};
  plant.armature = plant.coulomb = plant.viscous = JointVector::Zero(n);
  for (int i = 0; i < n; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    const std::string& name = plant.chain.joint_names()[slot];
    const int id = mj_name2id(&model, mjOBJ_JOINT, (robot.name + "/" + name).c_str());
    plant.position_address[slot] = model.jnt_qposadr[id];
    plant.velocity_address[slot] = model.jnt_dofadr[id];
    if (i == 0) plant.root = model.jnt_bodyid[id];
    const kinematics::Joint& joint = *robot.model->joint(name);
    const auto figures = std::ranges::find(robot.joints, name, &JointFigures::joint);
    const JointFigures known = figures == robot.joints.end() ? JointFigures{} : *figures;
    plant.armature[i] = known.armature;
    plant.coulomb[i] = known.coulomb.value_or(joint.friction);
    plant.viscous[i] = known.viscous.value_or(joint.damping);
  }
  const int base = mj_name2id(&model, mjOBJ_BODY, (robot.name + "/" + arm.base_link).c_str());
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_WB(data.xmat + 9 * base);
  plant.gravity_B = R_WB.transpose() * description.physics.gravity;
  plant.timestep = to_seconds(description.physics.timestep);
  plant.period = to_seconds(description.physics.period);
  if (arm.drive) {
    BaseDrive::Wheels turning(wheels.size());
    for (std::size_t i = 0; i < turning.size(); ++i) {
      const int id = mj_name2id(&model, mjOBJ_JOINT, (robot.name + "/" + wheels[i]).c_str());
      turning[i].velocity_address = model.jnt_dofadr[id];
      turning[i].inertia = model.dof_M0[turning[i].velocity_address];
    }
    const auto address = [&](const char* suffix) {
      return model.sensor_adr[mj_name2id(&model, mjOBJ_SENSOR, (support_sensor(arm.name) + suffix).c_str())];
    };
    const BaseDrive::Support support{.force_address = address("/force"), .torque_address = address("/torque")};
    plant.drive.emplace(*arm.drive, std::move(turning), support, description.seed, arm.name);
  }
  plant.payload = arm.payload ? *arm.payload : nominal_payload(description, arm.robot, arm.flange_link);
  return plant;
}

}  // namespace takt::sim
