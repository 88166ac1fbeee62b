#include "core/operations/table/tool_choice.h"
#include "core/base/keys_of.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::operations {
namespace {

using expression::Cell;
using expression::MountedTool;

std::vector<std::string> tools_on(const Cell& cell, const std::string& arm) {
  std::vector<std::string> names;
  for (const auto& [name, tool] : cell.tools)
    if (tool.arm == arm) names.push_back(name);
  return names;
}

/// A tool of another arm, or one that no arm has now.
Result<const MountedTool*> not_on(const Cell& cell, const std::string& arm, const std::string& name) {
  const auto tool = cell.tools.find(name);
  if (tool != cell.tools.end() && tool->second.arm.empty())
    return failure(Code::kNotPossibleNow, "/tool", fmt::format("'{}' is not coupled to '{}'", name, arm),
                   fmt::format("Put \"do\": \"couple\" of '{}' before it", tool->second.side));
  const auto there = tools_on(cell, arm);
  return failure(Code::kUnknownName, "/tool", fmt::format("'{}' carries no tool '{}'", arm, name),
                 there.empty() ? "Remove 'tool': it carries none" : nearest_choice(name, there));
}

/// The tool that is meant; null: the arm has none.
Result<const MountedTool*> tool_meant(const Cell& cell, const std::string& arm, const ToolChoice& choice) {
  const std::string& name = choice.tool.empty() ? cell.arms.find(arm)->second.tool_name : choice.tool;
  const auto found = cell.tools.find(name);
  if (found != cell.tools.end() && found->second.arm == arm) return &found->second;
  if (choice.tool.empty() && found == cell.tools.end()) return nullptr;
  return not_on(cell, arm, name);
}

/// A frame that the flange of the arm carries, as tool centre point.
Result<ToolInForce> frame_as_tool(const Cell& cell, const std::string& arm, const ToolChoice& choice,
                                  const MountedTool* tool) {
  const auto carrier = cell.frames.contains(choice.tcp) ? cell.carrier_of(choice.tcp) : std::nullopt;
  if (carrier && carrier->arm == arm && carrier->link.empty() && choice.tool.empty())
    return ToolInForce{.X_FT = carrier->X_FO};
  auto names = tool != nullptr ? keys_of(tool->X_FT) : std::vector<std::string>();
  if (cell.frames.contains(choice.tcp))
    return failure(Code::kUnknownPose, "/tcp", fmt::format("'{}' does not ride on the flange of '{}'", choice.tcp, arm),
                   "Name a tool centre point of its tool, or a frame of what it holds then");
  return failure(Code::kUnknownName, "/tcp", fmt::format("there is no tool centre point '{}'", choice.tcp),
                 nearest_choice(choice.tcp, names));
}

bool same(const device::ToolTip& a, const device::ToolTip& b) {
  return a.ball_radius == b.ball_radius && a.compliance_T == b.compliance_T;
}

}  // namespace

Result<ToolInForce> find_tool(const Cell& cell, const std::string& arm, const ToolChoice& choice) {
  const auto tool = tool_meant(cell, arm, choice);
  if (!tool) return std::unexpected(tool.error());
  const MountedTool* const meant = *tool;
  if (meant == nullptr && choice.tcp.empty()) {
    const expression::MountedArm& bare = cell.arms.find(arm)->second;
    return ToolInForce{bare.X_FT, bare.tip};
  }
  const std::string& tcp = choice.tcp.empty() ? meant->tcp : choice.tcp;
  const bool own = meant != nullptr && meant->X_FT.contains(tcp);
  if (!own) return frame_as_tool(cell, arm, choice, meant);
  return ToolInForce{meant->X_FT.find(tcp)->second, meant->tip};
}

bool changes_tool(const Cell& cell, const ArmTools& tools) {
  return std::ranges::any_of(tools, [&](const ArmTool& one) {
    const auto arm = cell.arms.find(one.arm);
    if (arm == cell.arms.end()) return false;
    const auto wanted = find_tool(cell, one.arm, one.choice);
    const auto& mounted = arm->second;
    return wanted && (wanted->X_FT.matrix() != mounted.X_FT.matrix() || !same(wanted->tip, mounted.tip));
  });
}

Diagnostics use_tools(Cell& cell, const ArmTools& tools) {
  Diagnostics diagnostics;
  for (const ArmTool& one : tools) {
    const auto arm = cell.arms.find(one.arm);
    if (arm == cell.arms.end()) continue;
    const auto wanted = find_tool(cell, one.arm, one.choice);
    if (!wanted) {
      diagnostics.append(wanted.error(), one.pointer);
      continue;
    }
    arm->second.X_FT = wanted->X_FT;
    arm->second.tip = wanted->tip;
  }
  return diagnostics;
}

}  // namespace takt::operations
