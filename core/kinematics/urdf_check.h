#pragma once

#include <filesystem>

#include "core/base/diagnostics.h"
#include "core/kinematics/xml_scan.h"

namespace takt::kinematics {

/// Most links of one robot.
inline constexpr std::size_t kMaxLinks = 1000;

/// Everything that is wrong in a scanned URDF, so that what passes can be handed to urdfdom and comes back unchanged:
/// urdfdom stops at the first error, knows no lines, and swallows NaN, loops and second parents.
/// Mesh names are resolved below `folder`. Realtime: setup.
[[nodiscard]] Diagnostics check_urdf(const XmlTree& tree, const std::filesystem::path& folder);

/// A diagnostic if there is a word of xacro in the file. It is a language of its own: running it is ROS's job, and what
/// its words stand for is not in the file. check_urdf() looks, too. Realtime: setup.
[[nodiscard]] Diagnostics check_no_xacro(const XmlTree& tree);

}  // namespace takt::kinematics
