#pragma once

#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/command/cell.h"
#include "core/device/description.h"
#include "core/device/device_file.h"
#include "core/kinematics/robot_model.h"
#include "scenario/description.h"

namespace takt::scenario {

using ArmModel = std::shared_ptr<const device::ArmDescription>;
using SensorModel = std::shared_ptr<const device::ForceTorqueDescription>;
using ToolModel = std::shared_ptr<const device::ToolDescription>;
using DeviceModel = std::variant<ArmModel, SensorModel, ToolModel>;

/// A device of the scenario with its model, and how it hangs on others.
struct LoadedDevice {
  const DeviceEntry* entry = nullptr;
  DeviceModel model;
  const LoadedDevice* on = nullptr;  ///< what it is mounted on; null: placed in a frame
};

/// Reads the models of all devices and joins those mounted on each other. Devices that carry come before those that
/// they carry. Findings: unknown models, devices mounted on nothing, on a tool, or in a circle.
[[nodiscard]] std::vector<std::unique_ptr<LoadedDevice>> load_devices(const Description& description,
                                                                      const device::ModelLibrary& models,
                                                                      Findings& findings);

/// The arm that carries a device through whatever is between; null if it stands in the room.
[[nodiscard]] const LoadedDevice* carrying_arm(const LoadedDevice& device);

/// Where the next part is screwed on, in the part's own mount frame (arms: the flange, handled by the caller).
[[nodiscard]] Eigen::Isometry3d flange_of(const LoadedDevice& device);

/// The URDF of a device.
[[nodiscard]] std::shared_ptr<const kinematics::RobotModel> robot_of(const DeviceModel& model);

/// Mass and centre of mass of a link and all that hangs below it, joints at zero, in that link's frame; no inertia.
[[nodiscard]] device::PayloadSetting mass_below(const kinematics::RobotModel& model, const std::string& link);

}  // namespace takt::scenario
