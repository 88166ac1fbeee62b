#pragma once

#include <string>

#include "core/expression/cell.h"

/// What controllers of arms are told that hangs on their flanges: the tool in force, and as payload tools and parts, as
/// the cell believes them. Realtime: setup.
namespace takt::expression {

/// What an arm is to be told: its tool centre point in force; as payload what hangs on it and what its grippers hold.
/// Of an arm whose grippers hold nothing that has a known mass, the mass that a program said counts.
[[nodiscard]] device::ToolSetting tool_setting(const Cell& cell, const std::string& arm);

/// Tells it to each arm that no net holds, if that is something new: payload and tool change between nets only.
void tell_tool_settings(Cell& cell);

/// The same in a rehearsal, which tells no device anything: plans reckon with it from now on.
void expect_tool_settings(Cell& cell);

/// Tool centre point of the tool that an arm has where a step names none, in the flange, m.
[[nodiscard]] Eigen::Isometry3d default_tcp(const Cell& cell, const std::string& arm);

/// Tool centre point of a gripper in the flange of its arm, whatever tool is in force, m.
[[nodiscard]] Eigen::Isometry3d gripping_point(const Cell& cell, const std::string& gripper);

}  // namespace takt::expression
