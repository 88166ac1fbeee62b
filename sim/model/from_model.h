#pragma once

#include <string>

#include "core/device/base_description.h"
#include "core/device/description.h"
#include "core/device/gripper.h"
#include "sim/model/world_description.h"

/// From what the models folder says of a device to its parts in a simulated world. Realtime: setup.
namespace takt::sim {

/// The body of an arm, with armature and friction as its device file and URDF give them, standing at its home position.
[[nodiscard]] RobotDescription arm_body(std::string name, const device::ArmDescription& model, Mount mount);
/// The simulated arm that drives the robot of that name.
[[nodiscard]] SimArmDescription simulated_arm(std::string name, std::string robot, const device::ArmDescription& model);

/// The simulated base that drives the robot of that name; its body is that of an arm. The odometry counts right.
[[nodiscard]] SimArmDescription simulated_base(std::string name, std::string robot,
                                               const device::BaseDescription& model);

/// The body of a force/torque sensor or of a tool: a robot without figures of its own.
[[nodiscard]] RobotDescription plain_body(std::string name, std::shared_ptr<const kinematics::RobotModel> model,
                                          Mount mount);
/// The simulated sensor between the two sides of the robot of that name.
[[nodiscard]] SimForceTorqueDescription simulated_force_torque(std::string name, const std::string& robot,
                                                               const device::ForceTorqueDescription& model);

/// The body of a gripper, with friction of its pads and inertia of its drive, its fingers `width` m apart.
[[nodiscard]] RobotDescription gripper_body(std::string name, const device::GripperDescription& model, Mount mount,
                                            double width);
/// The simulated gripper that drives the fingers of the robot of that name.
[[nodiscard]] SimGripperDescription simulated_gripper(std::string name, std::string robot,
                                                      const device::GripperDescription& model);

/// The simulated light barrier or range finder in the robot of that name.
[[nodiscard]] SimBeamDescription simulated_beam(std::string name, const std::string& robot,
                                                const device::BeamDescription& model);

}  // namespace takt::sim
