#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/device/description.h"

namespace takt::tools {

struct PictureOptions {
  std::string size;  ///< "WIDTHxHEIGHT"; empty: the default below
  int width = 960, height = 720;
  std::vector<double> q;  ///< positions of all movable joints in the order of the URDF; empty: home, or half open
};

/// Whether the simulator builds the model: what it says otherwise. Realtime: setup.
[[nodiscard]] Diagnostics check_build(const kinematics::RobotModel& robot, const device::ArmDescription* arm);

/// Draws a model alone on the floor, from the front right and above, as large as it fits, into a PNG.
/// @param arm  null for any other kind: its home is the posture   @param[in,out] options  the size is filled in
/// @return diagnostics: bad size or posture, a model that cannot be built, a file that cannot be written
[[nodiscard]] Result<void> draw_model(const kinematics::RobotModel& robot, const device::ArmDescription* arm,
                                      PictureOptions& options, const std::filesystem::path& file);

}  // namespace takt::tools
