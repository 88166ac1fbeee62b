#include "core/expression/tool_coupling.h"

#include "core/expression/tool_settings.h"

namespace takt::expression {
namespace {

using Eigen::Isometry3d;

/// The tools on a tool side are tools of this arm from now on; empty: of none.
void hang_tools(Cell& cell, const std::string& side, const std::string& arm, const Isometry3d& X_FS) {
  for (auto& [name, tool] : cell.tools) {
    if (tool.side != side) continue;
    tool.arm = arm;
    for (const auto& [tcp, X_ST] : tool.X_ST) tool.X_FT[tcp] = X_FS * X_ST;
    const auto gripper = cell.grippers.find(name);
    if (gripper != cell.grippers.end()) gripper->second.arm = arm;
  }
}

/// The tool that was in force may be gone: the next step names its own.
void reset_tool(Cell& cell, const std::string& name) {
  MountedArm& arm = cell.arms.find(name)->second;
  const auto tool = cell.tools.find(arm.tool_name);
  const bool there = tool != cell.tools.end() && tool->second.arm == name;
  arm.X_FT = default_tcp(cell, name);
  arm.tip = there ? tool->second.tip : device::ToolTip{};
}

/// What the tools on a tool side hold.
std::vector<std::string> held_by_tools_on(const Cell& cell, const std::string& side) {
  std::vector<std::string> parts;
  for (const auto& [name, tool] : cell.tools) {
    const auto held = cell.held.find(name);
    if (tool.side == side && held != cell.held.end()) parts.push_back(held->second.object);
  }
  return parts;
}

/// The coupling face of the changer counts where the default tool is not there.
void leave_tools(Cell& cell, const std::string& changer, const std::string& side) {
  hang_tools(cell, side, {}, Isometry3d::Identity());
  const MountedChanger& mounted = cell.changers.find(changer)->second;
  cell.arms.find(mounted.arm)->second.X_FT = mounted.X_FC;
  reset_tool(cell, mounted.arm);
}

}  // namespace

std::string coupled_side(const Cell& cell, std::string_view changer) {
  const auto held = cell.held.find(changer);
  return held != cell.held.end() && cell.changers.contains(changer) ? held->second.object : std::string();
}

std::optional<std::string> side_named(const Cell& cell, std::string_view name) {
  if (cell.tool_sides.contains(name)) return std::string(name);
  const auto tool = cell.tools.find(name);
  if (tool == cell.tools.end() || tool->second.side.empty()) return std::nullopt;
  return tool->second.side;
}

std::optional<std::string> side_at(const Cell& cell, const MountedChanger& changer, const Isometry3d& X_WC) {
  for (const auto& [name, side] : cell.tool_sides) {
    if (side.size != changer.size || cell.is_held(name)) continue;
    const auto X_WS = cell.frames.pose(name);
    if (X_WS && changer.tolerance.holds(X_WC.inverse() * *X_WS)) return name;
  }
  return std::nullopt;
}

Diagnostics couple(Cell& cell, const std::string& changer, const std::string& side) {
  const MountedChanger& mounted = cell.changers.find(changer)->second;
  const world::Hold hold{.object = side, .arm = mounted.arm, .X_FO = mounted.X_FC, .p_FG = mounted.X_FC.translation()};
  Diagnostics diagnostics = cell.take(changer, hold);
  if (diagnostics.has_errors()) return diagnostics;
  hang_tools(cell, side, mounted.arm, mounted.X_FC);
  reset_tool(cell, mounted.arm);
  return diagnostics;
}

Diagnostics uncouple(Cell& cell, const std::string& changer, const Isometry3d& X_WS, const std::string& onto) {
  const std::string side = coupled_side(cell, changer);
  const auto left = cell.let_go(changer, X_WS, onto);
  leave_tools(cell, changer, side);
  return left ? Diagnostics() : left.error();
}

void hang_coupled_tools(Cell& cell) {
  for (const auto& [side, one] : cell.tool_sides) hang_tools(cell, side, {}, Isometry3d::Identity());
  for (const auto& [changer, mounted] : cell.changers) {
    const std::string side = coupled_side(cell, changer);
    if (!side.empty()) hang_tools(cell, side, mounted.arm, mounted.X_FC);
  }
}

void lose_coupled(Cell& cell, const std::string& changer) {
  const std::string side = coupled_side(cell, changer);
  for (const std::string& part : held_by_tools_on(cell, side)) cell.lose(part);
  cell.lose(side);
  leave_tools(cell, changer, side);
}

}  // namespace takt::expression
