#include "sim/from_model.h"

#include <algorithm>
#include <utility>

#include "sim/description_check.h"

namespace takt::sim {

RobotDescription plain_body(std::string name, std::shared_ptr<const kinematics::RobotModel> model, Mount mount) {
  RobotDescription robot;
  robot.name = std::move(name);
  robot.model = std::move(model);
  robot.mount = std::move(mount);
  return robot;
}

RobotDescription arm_body(std::string name, const device::ArmDescription& model, Mount mount) {
  RobotDescription robot = plain_body(std::move(name), model.robot, std::move(mount));
  for (const kinematics::Joint* joint : movable_joints(*model.robot)) {
    const auto at = std::ranges::find(model.joint_names, joint->name);
    const bool driven = at != model.joint_names.end();
    const auto i = at - model.joint_names.begin();
    robot.q.push_back(driven ? model.home[i] : 0.0);
    if (!driven) continue;
    robot.joints.push_back({.joint = joint->name,
                            .armature = model.armature[i],
                            .coulomb = model.friction[i],
                            .viscous = model.damping[i]});
  }
  return robot;
}

SimArmDescription simulated_arm(std::string name, std::string robot, const device::ArmDescription& model) {
  SimArmDescription arm;
  arm.name = std::move(name);
  arm.robot = std::move(robot);
  arm.base_link = model.base_link;
  arm.flange_link = model.flange_link;
  arm.control.natural_frequency = model.natural_frequency;
  arm.control.damping_ratio = model.damping_ratio;
  arm.measurement = {.position_resolution = model.position_resolution,
                     .velocity_noise = model.velocity_noise,
                     .torque_sensors = model.torque_noise.size() > 0,
                     .torque_noise = model.torque_noise,
                     .torque_bias = model.torque_bias};
  return arm;
}

SimForceTorqueDescription simulated_force_torque(std::string name, const std::string& robot,
                                                 const device::ForceTorqueDescription& model) {
  SimForceTorqueDescription sensor;
  sensor.name = std::move(name);
  sensor.tool_side = robot + "/" + model.measuring_link;
  sensor.force_range = model.range.force;
  sensor.torque_range = model.range.torque;
  sensor.force_noise = model.noise.force;
  sensor.torque_noise = model.noise.torque;
  sensor.force_bias = model.bias.force;
  sensor.torque_bias = model.bias.torque;
  sensor.low_pass_Hz = model.low_pass_hz;
  sensor.period = model.cycle;
  return sensor;
}

}  // namespace takt::sim
