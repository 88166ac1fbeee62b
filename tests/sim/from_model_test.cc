// A cell made from nothing but the models folder: what the device files say must reach the simulated machines.
#include <gtest/gtest.h>

#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"
#include "tests/support/allocation_guard.h"

namespace takt::sim::test {
namespace {

WorldDescription model_cell() {
  const auto arm = device::read_arm("models/lwr4plus");
  const auto sensor = device::read_force_torque_sensor("models/ft_gamma");
  const auto probe = device::read_tool("models/probe_ball");
  EXPECT_TRUE(arm && sensor && probe);
  WorldDescription world;
  world.robots.push_back(arm_body("arm", **arm, {}));
  world.robots.push_back(plain_body("sensor", (*sensor)->robot, {.parent = "arm/" + (*arm)->flange_link}));
  world.robots.push_back(plain_body("probe", (*probe)->robot, {.parent = "sensor/" + (*sensor)->tool_link}));
  world.arms.push_back(simulated_arm("arm", "arm", **arm));
  world.force_torque_sensors.push_back(simulated_force_torque("wrist", "sensor", **sensor));
  return world;
}

TEST(FromModel, FiguresOfTheDeviceFileReachTheSimulation) {
  const WorldDescription world = model_cell();
  EXPECT_EQ(world.robots[0].joints.size(), 7u);
  EXPECT_EQ(world.robots[0].joints[4].armature, 0.3);
  EXPECT_EQ(world.robots[0].joints[4].coulomb, 0.4);
  EXPECT_EQ(world.robots[0].q[3], 1.5708);
  EXPECT_EQ(world.arms[0].control.natural_frequency[6], 80.0);
  EXPECT_EQ(world.arms[0].measurement.position_resolution, 1e-6);
  EXPECT_EQ(world.force_torque_sensors[0].tool_side, "sensor/measuring");
  EXPECT_EQ(world.force_torque_sensors[0].force_range.z(), 400.0);
  EXPECT_EQ(world.force_torque_sensors[0].low_pass_Hz, 500.0);
}

TEST(FromModel, ArmIsToldWhatItCarries) {
  World world = make(model_cell());
  const double expected = model("ft_gamma")->total_mass() + model("probe_ball")->total_mass();
  EXPECT_NEAR(world.arm("arm")->payload().mass, expected, 1e-12);
  EXPECT_GT(world.arm("arm")->payload().p_FC.z(), 0.02);
}

TEST(FromModel, HoldsStillWithAllItsNoise) {
  World world = make(model_cell());
  const Pose begin = world.body_pose(world.body("probe/tcp"));
  hold(world, lwr_home(), 1000);
  const Pose end = world.body_pose(world.body("probe/tcp"));
  EXPECT_LT((end.translation() - begin.translation()).norm(), 1e-4);
  device::ArmSample s = sample(world);
  EXPECT_EQ(s.tau.size(), 7);
  EXPECT_TRUE(s.ready);
}

TEST(FromModel, CycleDoesNotAllocate) {
  World world = make(model_cell());
  hold(world, lwr_home(), 10);
  device::ArmSample s = sample(world);
  device::WrenchSample w = wrench(world);
  const device::ArmSetPoint point = set_point(lwr_home());
  takt::test::AllocationGuard guard;
  for (int k = 0; k < 100; ++k) {
    (void)world.arm("arm")->read(s);
    (void)world.force_torque("wrist")->read(w);
    world.arm("arm")->write(point);
    if (k == 50) world.arm("arm")->brake();
    (void)world.step();
    (void)world.state_bytes();
  }
  EXPECT_EQ(guard.count(), 0u);
}

TEST(FromModel, PositionsHaveNames) {
  WorldDescription description = model_cell();
  ObjectDescription part = box("part", {0.05, 0.05, 0.05}, {0.6, 0.5, 0.2});
  part.free = true;
  part.mass = 0.5;
  description.objects.push_back(part);
  const World world = make(description);
  const auto names = world.position_names();
  ASSERT_EQ(names.size(), world.positions().size());
  EXPECT_EQ(names[0], "arm/a1");
  EXPECT_EQ(world.positions()[3], 1.5708);
  EXPECT_EQ(names[7], "part/x");
  EXPECT_EQ(names.back(), "part/qz");
  EXPECT_EQ(world.positions()[7], 0.6);
}

}  // namespace
}  // namespace takt::sim::test
