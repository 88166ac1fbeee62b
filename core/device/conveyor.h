#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "core/device/description.h"

namespace takt::device {

/// What is known of a conveyor: a belt with a drive that is started and stopped, and an encoder on it. It carries what
/// lies on it along x of its belt frame. The page: docs/devices/conveyor.md.
struct ConveyorDescription : ModelDescription {
  std::string mount_link;
  std::string belt_link;  ///< its collision shapes are the belt; origin where the belt begins, on its surface, z up
  Eigen::Isometry3d X_MB = Eigen::Isometry3d::Identity();  ///< that frame in the mount link, m
  double speed_max = 0.0;                                  ///< m/s, both ways
  double speed = 0.0;                                      ///< m/s, until a net sets another
  double acceleration = 0.0;                               ///< m/s^2, as it starts, stops and changes its speed
  double resolution = 0.0;                                 ///< m, of the encoder; 0: exact
  double noise = 0.0;                                      ///< m, sigma per sample of the encoder
  Nanoseconds cycle = kMillisecond;
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2)
};

/// As the other readers of core/device/device_file.h. Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const ConveyorDescription>> read_conveyor(const std::filesystem::path& folder);

/// The names of its terminals, its channel and its frame behind "NAME/".
namespace conveyor_terminal {
inline constexpr const char* kRun = "run";            ///< digital output: the drive
inline constexpr const char* kSpeed = "speed";        ///< analog output: m/s, while it runs
inline constexpr const char* kRunning = "running";    ///< digital input: the belt moves
inline constexpr const char* kPosition = "position";  ///< analog input: m since the start, of the encoder
inline constexpr const char* kPose = "pose";          ///< channel: the belt frame in that of the device
inline constexpr const char* kBelt = "belt";          ///< frame: goes with what lies on the belt
}  // namespace conveyor_terminal

}  // namespace takt::device
