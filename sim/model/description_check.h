#pragma once

#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "sim/model/world_description.h"

namespace takt::sim {

/// Everything wrong in a description that can be seen without compiling it: names, mounts, figures, devices; all at
/// once, each at the `pointer` of its part ("/robots/NAME" and so on where the part gives none). Realtime: setup.
[[nodiscard]] Diagnostics check(const WorldDescription& description);

/// Names of all bodies: "ROBOT/LINK" in the order of the links, then "OBJECT". Realtime: setup.
[[nodiscard]] std::vector<std::string> body_names(const WorldDescription& description);

/// Movable joints of a robot in the order of its URDF. Realtime: setup.
[[nodiscard]] std::vector<const kinematics::Joint*> movable_joints(const kinematics::RobotModel& model);

/// Where a part stands: its own pointer, else "/GROUP/NAME".
[[nodiscard]] std::string place(const std::string& pointer, std::string_view group, const std::string& name);

}  // namespace takt::sim
