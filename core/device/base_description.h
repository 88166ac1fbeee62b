#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/device/description.h"
#include "core/kinematics/wheel_drive.h"

namespace takt::device {

/// What is known of a mobile base model. The core drives it like an arm of three joints: x and y (m) and yaw (rad) of
/// its body in the frame in which its odometry counts (docs/devices/base.md). Flange F = its body, on the floor.
struct BaseDescription : ArmDescription {
  kinematics::WheelDrive drive;
  std::vector<std::string> wheels;                         ///< joints, in the order of the drive
  Eigen::Isometry3d X_FD = Eigen::Isometry3d::Identity();  ///< middle of the wheels in the body, m
  double wheel_speed = 0.0;                                ///< rad/s, largest
  double wheel_friction = 0.7;                             ///< on the floor; default: a guess, rubber on dry concrete
  std::string mount_link;                                  ///< what an arm is screwed to
  Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();  ///< its frame in the body, m
};

/// Reads <folder>/device.json of kind "base" and its URDF, as core/device/device_file.h says of the other kinds.
/// Limits: velocities and forces are the URDF's, accelerations and jerks the device file's. Those along x and y bound
/// the vector, so each axis of `limits` gets 1/sqrt(2) of them, and `cartesian` all. A differential drive makes the
/// limits nonholonomic. Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const BaseDescription>> read_base(const std::filesystem::path& folder);

}  // namespace takt::device
