#include "cell/build/cell_tools.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/keys_of.h"
#include "core/expression/tool_coupling.h"

#include "cell/build/cell_frames.h"
#include "cell/build/cell_models.h"

namespace takt::cell {
namespace {

void add_tool(const LoadedDevice& device, expression::Cell& cell, Diagnostics& diagnostics) {
  const auto tcps = tcps_of(device);
  const LoadedDevice* arm = carrying_arm(device);
  const std::string& wanted = device.entry->tcp;
  const LoadedDevice* side = tool_side_under(device);
  if (tcps.empty() || !(arm || side)) {
    if (!wanted.empty())
      diagnostics.error(Code::kInvalidValue, device.pointer() + "/tcp",
                        fmt::format("'{}' is no tool, it has no tool centre point", device.entry->name),
                        "Remove 'tcp'");
    return;
  }
  // On a tool side it hangs on an arm once that is coupled.
  expression::MountedTool tool{.arm = side ? std::string() : arm->entry->name, .tip = device.kind->tip(*device.model)};
  for (const auto& [name, X_MT] : tcps) tool.X_FT[name] = (side ? pose_on_side(device) : pose_on_arm(device)) * X_MT;
  if (side) {
    tool.side = side->entry->name;
    tool.X_ST = tool.X_FT;
    if (const auto gripper = cell.grippers.find(device.entry->name); gripper != cell.grippers.end())
      gripper->second.arm.clear();
  }
  if (!wanted.empty()) tool.tcp = wanted;
  if (!tcps.contains(tool.tcp)) {
    diagnostics.error(wanted.empty() ? Code::kMissing : Code::kUnknownName, device.pointer() + "/tcp",
                      fmt::format("'{}' has no tool centre point '{}'", device.entry->name, tool.tcp),
                      nearest_choice(tool.tcp, keys_of(tcps)));
    return;
  }
  cell.tools[device.entry->name] = std::move(tool);
}

std::vector<std::string> tools_on(const expression::Cell& cell, const std::string& arm) {
  std::vector<std::string> names;
  for (const auto& [name, tool] : cell.tools)
    if (tool.arm == arm) names.push_back(name);
  return names;
}

/// The tool that counts on an arm where a step names none; empty: the flange.
std::string default_tool(const LoadedDevice& arm, const expression::Cell& cell, Diagnostics& diagnostics) {
  const std::string& wanted = arm.entry->tool;
  const auto tools = tools_on(cell, arm.entry->name);
  const std::string pointer = arm.pointer() + "/tool";
  if (wanted.empty() && tools.size() <= 1) return tools.empty() ? std::string() : tools.front();
  if (wanted.empty()) {
    diagnostics.error(Code::kMissing, pointer,
                      fmt::format("'{}' carries several tools: {}", arm.entry->name, fmt::join(tools, ", ")),
                      fmt::format("Give \"tool\": \"{}\" beside the model of '{}', for steps that name none",
                                  tools.front(), arm.entry->name));
    return {};
  }
  if (std::ranges::find(tools, wanted) != tools.end()) return wanted;
  if (const auto tool = cell.tools.find(wanted); tool != cell.tools.end() && !tool->second.side.empty()) return wanted;
  diagnostics.error(Code::kUnknownName, pointer, fmt::format("'{}' carries no tool '{}'", arm.entry->name, wanted),
                    tools.empty() ? "Name a tool that is mounted \"on\" it" : nearest_choice(wanted, tools));
  return {};
}

/// Tool sides that the file has on a changer. Two of the same size with one number could not be told apart.
void couple_at_start(LoadedDevices devices, expression::Cell& cell, Diagnostics& diagnostics) {
  std::map<std::pair<std::string, int>, std::string> numbers;
  std::map<std::string, std::string> coupled;
  for (const auto& device : devices) {
    const std::string& name = device->entry->name;
    const auto side = cell.tool_sides.find(name);
    if (side == cell.tool_sides.end()) continue;
    const auto [first, is_new] = numbers.emplace(std::pair(side->second.size, side->second.number), name);
    if (!is_new)
      diagnostics.error(Code::kDuplicate, device->pointer() + "/settings/number",
                        fmt::format("'{}' has the number {}, too", first->second, side->second.number),
                        "Give each a number of its own");
    if (!device->on) continue;
    const auto [other, is_alone] = coupled.emplace(device->entry->on, name);
    if (is_alone) {
      diagnostics.append(expression::couple(cell, device->entry->on, name), device->pointer());
    } else {
      diagnostics.error(Code::kConflict, device->pointer() + "/on",
                        fmt::format("'{}' hangs on '{}' already", other->second, device->entry->on),
                        "Give \"at\": a free dock");
    }
  }
}

}  // namespace

void add_tools(LoadedDevices devices, expression::Cell& cell, Diagnostics& diagnostics) {
  for (const auto& device : devices) add_tool(*device, cell, diagnostics);
  couple_at_start(devices, cell, diagnostics);
  for (const auto& device : devices) {
    const auto arm = cell.arms.find(device->entry->name);
    if (arm == cell.arms.end()) {
      for (const auto& [key, value] : {std::pair("tool", device->entry->tool), {"own_force", device->entry->own_force}})
        if (!value.empty())
          diagnostics.error(Code::kInvalidValue, device->pointer() + pointer_segment(key),
                            fmt::format("'{}' is no arm", device->entry->name),
                            fmt::format("Give \"{}\" of an arm", key));
      continue;
    }
    arm->second.tool_name = default_tool(*device, cell, diagnostics);
    const auto tool = cell.tools.find(arm->second.tool_name);
    if (tool == cell.tools.end() || tool->second.arm != arm->first) continue;
    arm->second.X_FT = tool->second.X_FT.find(tool->second.tcp)->second;
    arm->second.tip = tool->second.tip;
  }
}

}  // namespace takt::cell
