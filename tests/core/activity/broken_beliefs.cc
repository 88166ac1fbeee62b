// Wrong uses of parts, loads, tools and frames: what the cell believes forbids them.
#include "app/interfaces/frame_handle.h"
#include "tests/core/activity/broken_activities.h"

namespace takt::test {
namespace {

using app::Actuator;
using app::Frame;
using app::GrippingInterface;

/// A free part of 0.5 kg beside the block.
void add_part(ActivityCell& cell) {
  Eigen::Isometry3d X_WO = *cell.cell.frames.pose("block");
  X_WO.translation().x() += 0.2;
  ASSERT_TRUE(cell.cell.frames.add("part", "world", X_WO).empty());
  cell.cell.objects["part"] = {.name = "part", .parts = {{world::Box{{0.04, 0.04, 0.04}}}}, .mass = {.mass = 0.5}};
}

/// The gripper holds it, as far as the program knows.
void hold_part(ActivityCell& cell) {
  add_part(cell);
  ASSERT_TRUE(cell.cell.take("gripper", {.object = "part", .arm = "arm"}).empty());
}

/// Closes the gripper, which finds something after a while.
void grip_part(ActivityCell& cell, const operations::GripParameters& parameters) {
  const auto run = Actuator(cell.program, "gripper").use<GrippingInterface>().close(parameters).begin_execute();
  for (int i = 0; i < 10; ++i) cell.program.step();
  cell.fingers->answer(device::GripperState::kHolding, 0.04);
  wait(cell.program, run);
}

}  // namespace

std::vector<BrokenActivity> broken_beliefs() {
  return {
      {"a part that is told to weigh more than it does",
       [](auto& cell) {
         add_part(cell);
         grip_part(cell, {.part = "part", .part_mass = 2.0});
       },
       "/grip gripper/part_mass_kg",
       Code::kPayloadMismatch,
       {"part", "0.5", "2"},
       true},
      {"a load that is not what the gripper holds",
       [](auto& cell) {
         hold_part(cell);
         cell.robot.carry(2.0);
       },
       "/arm",
       Code::kPayloadMismatch,
       {"arm", "0.5", "2"}},
      {"another tool centre point on the way",
       [](auto& cell) {
         hold_part(cell);
         cell.motion.lin_by({0.0, 0.0, 0.05}).begin_execute();
         cell.robot.use_tool("", "part");
       },
       "/arm",
       Code::kNotPossibleNow,
       {"arm"},
       true},
      {"a tool centre point that stays where it is",
       [](auto& cell) { cell.robot.use_tool("", "block"); },
       "/arm/tcp",
       Code::kUnknownPose,
       {"block", "arm"}},
      {"a tool centre point that is not there",
       [](auto& cell) { cell.robot.use_tool("", "tip"); },
       "/arm/tcp",
       Code::kUnknownName,
       {"tip"}},
      {"a tool that the arm does not have",
       [](auto& cell) { cell.robot.use_tool("drill"); },
       "/arm/tool",
       Code::kUnknownName,
       {"arm", "drill"}},
      {"a frame with the name of another one",
       [](auto& cell) { (void)Frame(cell.program, "block").offset(0.0, 0.0, 0.1).keep_as("arm"); },
       "/block",
       Code::kInvalidName,
       {"arm"}},
      {"a frame of a scope with the name of another one",
       [](auto& cell) { const app::ScopedFrame twice(Frame(cell.program, "block"), "block"); },
       "/block",
       Code::kDuplicate,
       {"block"}},
      {"a frame with a name of many parts",
       [](auto& cell) { (void)Frame(cell.program, "block").keep_as("block/top"); },
       "/block",
       Code::kInvalidName,
       {"block/top"}},
  };
}

}  // namespace takt::test
