#pragma once

#include <filesystem>

#include "core/base/findings.h"
#include "core/kinematics/xml_scan.h"

namespace takt::kinematics {

/// Most links of one robot.
inline constexpr std::size_t kMaxLinks = 1000;

/// Everything that is wrong in a scanned URDF, so that what passes can be handed to urdfdom and comes back unchanged:
/// urdfdom stops at the first error, knows no lines, and swallows NaN, loops and second parents.
/// Mesh names are resolved below `folder`. Realtime: setup.
[[nodiscard]] Findings check_urdf(const XmlTree& tree, const std::filesystem::path& folder);

}  // namespace takt::kinematics
