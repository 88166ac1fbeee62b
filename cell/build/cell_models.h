#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cell/build/device_kind.h"
#include "cell/file/description.h"
#include "core/device/backend.h"
#include "core/device/device_file.h"
#include "core/kinematics/robot_model.h"

namespace takt::cell {

/// Reads the models of all devices and joins those mounted on each other. Devices that carry come before those that
/// they carry. Diagnostics: unknown models, devices mounted on nothing, on what carries nothing, or in a circle.
[[nodiscard]] std::vector<std::unique_ptr<LoadedDevice>> load_devices(const Description& description,
                                                                      const device::ModelLibrary& models,
                                                                      Diagnostics& diagnostics);

/// The arm that carries a device through whatever is between; null if it stands in the room.
[[nodiscard]] const LoadedDevice* carrying_arm(const LoadedDevice& device);

/// The tool side of a tool changer that a device is mounted on, directly or through others; null: none.
[[nodiscard]] const LoadedDevice* tool_side_under(const LoadedDevice& device);

/// As the program believes it to be, or as it was drawn.
enum class MountAs : std::uint8_t { kBelieved, kTrue };

/// Pose of a mounted device's mount frame in the coupling face of the tool side below it.
[[nodiscard]] Eigen::Isometry3d pose_on_side(const LoadedDevice& device, MountAs as = MountAs::kBelieved);

/// Pose of a mounted device's mount frame in the flange of the arm that carries it.
[[nodiscard]] Eigen::Isometry3d pose_on_arm(const LoadedDevice& device, MountAs as = MountAs::kBelieved);

/// Mass and centre of mass of a link and all that hangs below it, joints at zero, in that link's frame; no inertia.
[[nodiscard]] device::PayloadSetting mass_below(const kinematics::RobotModel& model, const std::string& link);

}  // namespace takt::cell
