#pragma once

#include <filesystem>
#include <string>

#include "core/base/diagnostics.h"

namespace takt::tools {

/// A tool or a gripper to begin with, of plain shapes.
struct DeviceOptions {
  std::string name;           ///< of the model: a-z, 0-9, _
  std::filesystem::path out;  ///< the folder of models that gets the folder `name`
  std::string title;          ///< for people; empty: the name
  double length_m = 0.15;     ///< from the mounting face to the tip, 0.03 to 1
  double mass_kg = 0.5;       ///< of all of it, 0.01 to 50
  double stroke_m = 0.1;      ///< of a gripper: between the open fingers, 0.005 to 0.5
  double force_N = 100.0;     ///< of a gripper: the largest grasping force, 1 to 5000
};

/// Figures out of range; a name that is none, or that is there already.
[[nodiscard]] Diagnostics check(const DeviceOptions& options);

/// Makes the folder out/name: URDF, device file, README that lists what was assumed. The model can be mounted as it is.
/// @return the folder. Realtime: setup.
[[nodiscard]] Result<std::filesystem::path> new_tool(const DeviceOptions& options);
[[nodiscard]] Result<std::filesystem::path> new_gripper(const DeviceOptions& options);

}  // namespace takt::tools
