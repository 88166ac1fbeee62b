#include "core/expression/tool_settings.h"

#include <algorithm>

namespace takt::expression {
namespace {

device::PayloadSetting payload_of(const world::MassProperties& body) { return {body.mass, body.p_OC, body.I_C}; }

bool same(const device::ToolSetting& a, const device::ToolSetting& b) {
  return a.X_FT.matrix() == b.X_FT.matrix() && a.payload.mass == b.payload.mass && a.payload.p_FC == b.payload.p_FC &&
         a.payload.I_C == b.payload.I_C;
}

/// Nothing was ever said that differs from what the device knows by itself.
bool is_untouched(const Cell& cell, const std::string& name, const MountedArm& arm) {
  return !arm.unloaded && arm.tool_name.empty() && arm.told_mass == 0.0 && cell.load_of(name).mass == 0.0;
}

}  // namespace

device::ToolSetting tool_setting(const Cell& cell, const std::string& name) {
  const MountedArm& arm = cell.arms.find(name)->second;
  const world::MassProperties load = cell.load_of(name);
  const auto carried = load.mass > 0.0 ? payload_of(load)
                                       : device::PayloadSetting{.mass = arm.told_mass, .p_FC = arm.X_FT.translation()};
  const device::PayloadSetting unloaded = arm.unloaded.value_or(arm.tool().payload);
  return {arm.X_FT, carried.mass > 0.0 ? device::combine(unloaded, carried) : unloaded};
}

void tell_tool_settings(Cell& cell) {
  for (auto& [name, arm] : cell.arms) {
    if (arm.device == nullptr || arm.device->held() || is_untouched(cell, name, arm)) continue;
    if (!arm.unloaded) arm.unloaded = arm.tool().payload;
    const device::ToolSetting setting = tool_setting(cell, name);
    if (!same(setting, arm.device->tool())) arm.device->set_tool(setting);
  }
}

void expect_tool_settings(Cell& cell) {
  for (auto& [name, arm] : cell.arms) {
    if (arm.device == nullptr || is_untouched(cell, name, arm)) continue;
    if (!arm.unloaded) arm.unloaded = arm.tool().payload;
    arm.expected = tool_setting(cell, name);
  }
}

Eigen::Isometry3d default_tcp(const Cell& cell, const std::string& name) {
  const MountedArm& arm = cell.arms.find(name)->second;
  const auto tool = cell.tools.find(arm.tool_name);
  return tool == cell.tools.end() || tool->second.arm != name ? arm.X_FT
                                                              : tool->second.X_FT.find(tool->second.tcp)->second;
}

Eigen::Isometry3d gripping_point(const Cell& cell, const std::string& gripper) {
  const auto tool = cell.tools.find(gripper);
  if (tool != cell.tools.end()) return tool->second.X_FT.find(tool->second.tcp)->second;
  const auto mounted = cell.grippers.find(gripper);
  const auto arm = mounted == cell.grippers.end() ? cell.arms.end() : cell.arms.find(mounted->second.arm);
  return arm == cell.arms.end() ? Eigen::Isometry3d::Identity() : arm->second.X_FT;
}

}  // namespace takt::expression
