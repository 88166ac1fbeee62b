#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <Eigen/Geometry>

#include "core/base/diagnostics.h"
#include "core/device/description.h"

/// The two halves of a tool changer. The page: docs/devices/tool-changer.md.
namespace takt::device {

/// How far the coupling face of a tool side may be from that of the robot side when the lock closes.
struct CouplingTolerance {
  double offset = 0.0;  ///< m, across the axis
  double gap = 0.0;     ///< m, along the axis, either way
  double angle = 0.0;   ///< rad, about any axis

  /// @param X_CS  coupling face of the tool side in that of the robot side; coupled: identity. Realtime: cyclic.
  [[nodiscard]] bool holds(const Eigen::Isometry3d& X_CS) const;
};

/// What is known of a robot side: a pneumatic lock on the flange of an arm. Without air it stays as it is.
struct ToolChangerDescription : ModelDescription {
  std::string mount_link;
  std::string coupling_link;                               ///< z towards the tool
  Eigen::Isometry3d X_MC = Eigen::Isometry3d::Identity();  ///< coupling face in the mount frame, m
  std::string size;                                        ///< tool sides of the same size fit
  CouplingTolerance tolerance;
  double lock_time = 0.0;  ///< s, from one end to the other
  Nanoseconds cycle = kMillisecond;
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2): 20 device cycles
};

/// What is known of a tool side: a plate on which one tool is mounted. Its base is its coupling face.
struct ToolSideDescription : ModelDescription {
  std::string coupling_link;
  std::string tool_link;                                   ///< that carries the tool
  Eigen::Isometry3d X_ST = Eigen::Isometry3d::Identity();  ///< of its origin in the coupling face, m
  std::string size;
};

/// As the other readers of core/device/device_file.h. Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const ToolChangerDescription>> read_tool_changer(
    const std::filesystem::path& folder);
[[nodiscard]] Result<std::shared_ptr<const ToolSideDescription>> read_tool_side(const std::filesystem::path& folder);

/// The names of its terminals behind "NAME/".
namespace changer_terminal {
inline constexpr const char* kLock = "lock";                  ///< digital output: true locks, false unlocks
inline constexpr const char* kLocked = "locked";              ///< digital inputs: the lock is at this end,
inline constexpr const char* kUnlocked = "unlocked";          ///< or at that one;
inline constexpr const char* kReadyToLock = "ready_to_lock";  ///< a tool side is where it could be coupled;
inline constexpr const char* kCoupled = "coupled";            ///< locked, with a tool side in it
inline constexpr const char* kToolNumber = "tool_number";     ///< analog input: of the coupled tool side; 0: none
}  // namespace changer_terminal

}  // namespace takt::device
