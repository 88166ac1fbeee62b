// Which tool counts on an arm, and whether another one would.
#include "core/operations/table/tool_choice.h"

#include <gtest/gtest.h>

namespace takt::operations {
namespace {

/// Two probes with the same tool centre point; the second one's stylus gives way.
expression::Cell two_probes() {
  expression::Cell cell;
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
  X_FT.translation().z() = 0.1;
  expression::MountedTool stiff{.arm = "arm", .X_FT = {{std::string(expression::MountedTool::kOwnTcp), X_FT}}};
  stiff.tip.ball_radius = 0.005;
  expression::MountedTool sprung = stiff;
  sprung.tip.compliance_T.z() = 1e-4;
  cell.tools["stiff"] = stiff;
  cell.tools["sprung"] = sprung;
  expression::MountedArm arm;
  arm.X_FT = X_FT;
  arm.tip = stiff.tip;
  arm.tool_name = "stiff";
  cell.arms["arm"] = arm;
  return cell;
}

TEST(ToolChoice, AToolThatOnlyGivesWayDifferentlyIsAnotherOne) {
  expression::Cell cell = two_probes();
  const ArmTools stiff{{.arm = "arm", .choice = {}, .pointer = {}}};
  const ArmTools sprung{{.arm = "arm", .choice = {.tool = "sprung"}, .pointer = {}}};
  EXPECT_FALSE(changes_tool(cell, stiff));
  EXPECT_TRUE(changes_tool(cell, sprung));
  ASSERT_FALSE(use_tools(cell, sprung).has_errors());
  EXPECT_EQ(cell.arms["arm"].tip.compliance_T.z(), 1e-4);
  EXPECT_FALSE(changes_tool(cell, sprung));
  EXPECT_TRUE(changes_tool(cell, stiff));
}

}  // namespace
}  // namespace takt::operations
