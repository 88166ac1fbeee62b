#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "core/kinematics/chain.h"
#include "sim/description_check.h"
#include "sim/nominal_payload.h"
#include "sim/world_impl.h"

namespace takt::sim {

Result<ArmPlant> World::Impl::arm_plant(const WorldDescription& description, const SimArmDescription& arm) {
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
                      "one for each joint, or none");
  }
  if (wrong_sizes.has_errors()) return std::unexpected(std::move(wrong_sizes));
  ArmPlant plant{.chain = std::move(*chain)};
  plant.armature = plant.coulomb = plant.viscous = JointVector::Zero(n);
  for (int i = 0; i < n; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    const std::string& name = plant.chain.joint_names()[slot];
    const int id = mj_name2id(model.get(), mjOBJ_JOINT, (robot.name + "/" + name).c_str());
    plant.position_address[slot] = model->jnt_qposadr[id];
    plant.velocity_address[slot] = model->jnt_dofadr[id];
    if (i == 0) plant.root = model->jnt_bodyid[id];
    const kinematics::Joint& joint = *robot.model->joint(name);
    const auto figures = std::ranges::find(robot.joints, name, &JointFigures::joint);
    const JointFigures known = figures == robot.joints.end() ? JointFigures{} : *figures;
    plant.armature[i] = known.armature;
    plant.coulomb[i] = known.coulomb.value_or(joint.friction);
    plant.viscous[i] = known.viscous.value_or(joint.damping);
  }
  const int base = mj_name2id(model.get(), mjOBJ_BODY, (robot.name + "/" + arm.base_link).c_str());
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_WB(data->xmat + 9 * base);
  plant.gravity_B = R_WB.transpose() * description.physics.gravity;
  plant.timestep = to_seconds(description.physics.timestep);
  plant.period = to_seconds(description.physics.period);
  if (arm.drive) {
    BaseDrive::Wheels turning(wheels.size());
    for (std::size_t i = 0; i < turning.size(); ++i) {
      const int id = mj_name2id(model.get(), mjOBJ_JOINT, (robot.name + "/" + wheels[i]).c_str());
      turning[i].velocity_address = model->jnt_dofadr[id];
      turning[i].inertia = model->dof_M0[turning[i].velocity_address];
    }
    plant.drive.emplace(*arm.drive, std::move(turning), description.seed, arm.name);
  }
  plant.payload = arm.payload ? *arm.payload : nominal_payload(description, arm.robot, arm.flange_link);
  return plant;
}

Diagnostics World::Impl::add_arms(const WorldDescription& description) {
  Diagnostics diagnostics;
  for (const auto& arm : description.arms) {
    auto plant = arm_plant(description, arm);
    if (!plant) {
      diagnostics.append(plant.error());
      continue;
    }
    const int root = plant->root;
    add(arm.name, std::make_unique<SimArm>(arm, std::move(*plant), description.seed));
    if (arm.drive) rest.add_driven(*model, root, *devices.back());
  }
  return diagnostics;
}

void World::Impl::add_sensors(const WorldDescription& description) {
  for (const auto& sensor : description.force_torque_sensors) {
    const auto address = [&](std::string_view suffix) {
      return model->sensor_adr[mj_name2id(model.get(), mjOBJ_SENSOR, fmt::format("{}{}", sensor.name, suffix).c_str())];
    };
    add(sensor.name, std::make_unique<SimForceTorque>(sensor, address("/force"), address("/torque"),
                                                      description.physics, description.seed));
  }
}

void World::Impl::add_grippers(const WorldDescription& description) {
  for (const auto& gripper : description.grippers) {
    SimGripper::Plant plant;
    for (std::size_t i = 0; i < gripper.fingers.size(); ++i) {
      const int id = mj_name2id(model.get(), mjOBJ_JOINT, (gripper.robot + "/" + gripper.fingers[i]).c_str());
      plant.position_address[i] = model->jnt_qposadr[id];
      plant.velocity_address[i] = model->jnt_dofadr[id];
    }
    add(gripper.name, std::make_unique<SimGripper>(gripper, plant));
  }
}

void World::Impl::add_tool_changers(const WorldDescription& description) {
  for (const auto& changer : description.tool_changers)
    add(changer.name, std::make_unique<SimToolChanger>(changer, description, *model));
}

void World::Impl::add_signals(const WorldDescription& description) {
  for (const auto& output : description.outputs) add(output.name, std::make_unique<SimOutput>(output));
  for (const auto& beam : description.beams) {
    const int body = mj_name2id(model.get(), mjOBJ_BODY, beam.body.c_str());
    add(beam.name, std::make_unique<SimBeam>(beam, *model, body, description.seed));
  }
  for (const auto& input : description.inputs) {
    const SimOutput* output = find<SimOutput>(input.source);
    const SimBeam* beam = find<SimBeam>(input.source);
    const double* wire = output ? output->wire() : beam ? beam->wire() : nullptr;
    add(input.name, std::make_unique<SimInput>(input, wire, description.seed));
  }
  lamps = takt::sim::lamp_wires(description);
  for (const std::string& lamp : lamps) {
    const SimOutput* output = find<SimOutput>(lamp);
    lamp_wires.push_back(output ? output->wire() : find<SimBeam>(lamp)->wire());
  }
}

Diagnostics World::Impl::add_others(const WorldDescription& description) {
  Diagnostics diagnostics;
  for (const auto& one : description.devices) {
    auto device = one.make(*model, description);
    if (!device) {
      diagnostics.append(device.error(), place(one.pointer, "devices", one.name));
      continue;
    }
    add(one.name, std::move(*device));
  }
  return diagnostics;
}

void World::Impl::set_start(const WorldDescription& description) {
  for (const auto& robot : description.robots) {
    const auto joints = movable_joints(*robot.model);
    for (std::size_t i = 0; i < robot.q.size(); ++i) {
      const int id = mj_name2id(model.get(), mjOBJ_JOINT, (robot.name + "/" + joints[i]->name).c_str());
      data->qpos[model->jnt_qposadr[id]] = robot.q[i];
    }
  }
  forward();
}

}  // namespace takt::sim
