#pragma once

#include <optional>
#include <string>

#include "cell/build/built_cell.h"

/// Where things truly are, for expectations: nothing that a program may look at. Realtime: setup.
namespace takt::cell {

/// An object, or a body "DEVICE/LINK", in the world, m.
[[nodiscard]] Eigen::Isometry3d true_pose(const BuiltCell& built, const std::string& body);

/// A frame of the cell: what it rides on is where the simulation has it. Nothing: there is no such frame, or nobody
/// knows what it depends on.
[[nodiscard]] std::optional<Eigen::Isometry3d> true_frame(const BuiltCell& built, const std::string& frame);

/// The tool that an arm has where a step names none, in the world, m.
[[nodiscard]] Eigen::Isometry3d true_tool(const BuiltCell& built, const std::string& arm);

}  // namespace takt::cell
