#include "sim/model/from_model.h"

#include <algorithm>
#include <utility>

#include "sim/model/description_check.h"

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
  arm.control.friction_observer = model.friction_observer;
  arm.control.modes = model.modes;
  arm.control.impedance = model.impedance;
  arm.control.limits = model.limits;
  arm.measurement = {.position_resolution = model.position_resolution,
                     .velocity_noise = model.velocity_noise,
                     .torque_sensors = model.torque_noise.size() > 0,
                     .torque_at_motor = model.torque_at_motor,
                     .torque_noise = model.torque_noise,
                     .torque_bias = model.torque_bias};
  arm.measurement.delay = model.measurement_delay;
  arm.measurement.period = model.measurement_period;
  return arm;
}

SimArmDescription simulated_base(std::string name, std::string robot, const device::BaseDescription& model) {
  SimArmDescription base = simulated_arm(std::move(name), std::move(robot), model);
  base.drive = SimDriveDescription{
      .drive = model.drive, .wheels = model.wheels, .X_FD = model.X_FD, .grip = model.wheel_friction};
  return base;
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

RobotDescription gripper_body(std::string name, const device::GripperDescription& model, Mount mount, double width) {
  RobotDescription robot = plain_body(std::move(name), model.robot, std::move(mount));
  for (const kinematics::Joint* joint : movable_joints(*model.robot)) {
    const bool finger = std::ranges::find(model.fingers, joint->name) != model.fingers.end();
    robot.q.push_back(finger ? 0.5 * width : 0.0);
    if (finger) robot.joints.push_back({.joint = joint->name, .armature = model.finger_inertia});
  }
  // Pads of rubber on the fingers, which resist twisting.
  ContactParameters pad;
  pad.material = "rubber";
  pad.friction = model.pad_friction;
  pad.own_friction = pad.by_rules = true;
  pad.torsion = 0.005;
  for (const std::string& finger : model.fingers) robot.link_contacts[model.robot->joint(finger)->child] = pad;
  robot.stop_margin = 0.0;
  return robot;
}

SimGripperDescription simulated_gripper(std::string name, std::string robot, const device::GripperDescription& model) {
  SimGripperDescription gripper;
  gripper.name = std::move(name);
  gripper.robot = std::move(robot);
  for (std::size_t i = 0; i < gripper.fingers.size(); ++i) {
    gripper.fingers[i] = model.fingers[i];
    const kinematics::Link* finger = model.robot->link(model.robot->joint(model.fingers[i])->child);
    if (finger->inertial) gripper.finger_mass = std::max(gripper.finger_mass, finger->inertial->mass);
  }
  gripper.finger_inertia = model.finger_inertia;
  gripper.speed_max = model.speed_max;
  gripper.acceleration = model.acceleration;
  gripper.force_min = model.force_min;
  gripper.force_max = model.force_max;
  gripper.width_resolution = model.width_resolution;
  gripper.period = model.cycle;
  return gripper;
}

SimBeamDescription simulated_beam(std::string name, const std::string& robot, const device::BeamDescription& model) {
  SimBeamDescription beam;
  beam.name = std::move(name);
  beam.body = robot + "/" + model.beam_link;
  beam.measures_range = model.measures_range;
  beam.range_min = model.range_min;
  beam.range_max = model.range_max;
  beam.resolution = model.resolution;
  beam.noise = model.noise;
  beam.period = model.cycle;
  return beam;
}

}  // namespace takt::sim
