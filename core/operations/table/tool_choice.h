#pragma once

#include <string>
#include <vector>

#include "core/expression/cell.h"

/// Which tool of its arm an operation works with (docs/world.md, "Tools by name"). Realtime: setup.
namespace takt::operations {

/// As a program names it; empty: the default that the cell declares.
struct ToolChoice {
  std::string tool = {};  ///< a device that has a tool centre point
  std::string tcp = {};   ///< of the tool; or a frame that rides on the flange, of a held part for instance

  [[nodiscard]] bool is_default() const { return tool.empty() && tcp.empty(); }
  friend bool operator==(const ToolChoice&, const ToolChoice&) = default;
};

/// What an operation wants on one of its arms.
struct ArmTool {
  std::string arm;
  ToolChoice choice;
  std::string pointer;  ///< of the operation in its file
};
using ArmTools = std::vector<ArmTool>;

/// The tool centre point that counts on an arm, and what is there.
struct ToolInForce {
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();  ///< in the flange, m
  device::ToolTip tip = {};
};

/// @return diagnostics "/tool" or "/tcp": there is no such thing on this arm
[[nodiscard]] Result<ToolInForce> find_tool(const expression::Cell& cell, const std::string& arm,
                                            const ToolChoice& choice);

/// Another tool centre point than the one in force, as far as it is known which.
[[nodiscard]] bool changes_tool(const expression::Cell& cell, const ArmTools& tools);

/// Puts the tools in force: everything that is planned, sensed or told for these arms from now on is about them.
/// @return diagnostics with the pointers of the operations
[[nodiscard]] Diagnostics use_tools(expression::Cell& cell, const ArmTools& tools);

}  // namespace takt::operations
