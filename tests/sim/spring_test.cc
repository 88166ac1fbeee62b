// Joints that a spring holds: a sprung probe gives way by force over stiffness, and comes back.
#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/sim/cell.h"
#include "tests/support/reports.h"

namespace takt::sim::test {
namespace {

constexpr double kStiffness = 20'000.0, kPreload = 1.0;

/// A probe that stands on the world with its stylus upwards.
WorldDescription standing_probe() {
  WorldDescription world;
  RobotDescription probe;
  probe.name = "probe";
  probe.model = model("probe_sprung");
  probe.joints.push_back(
      {.joint = "plunge", .spring = JointSpring{.stiffness = kStiffness, .damping = 20.0, .preload = kPreload}});
  for (const char* tilt : {"tilt_x", "tilt_y"})
    probe.joints.push_back({.joint = tilt, .spring = JointSpring{.stiffness = 160.0, .damping = 0.16}});
  world.robots.push_back(probe);
  return world;
}

double plunge(const World& world) {
  const auto names = world.position_names();
  const auto at = std::ranges::find(names, "probe/plunge");
  return world.positions()[static_cast<std::size_t>(at - names.begin())];
}

TEST(Springs, GiveWayByForceOverStiffnessBeyondThePreload) {
  World world = make(standing_probe());
  for (const double force : {0.5, 5.0, 20.0, 0.5}) {
    world.push(world.body("probe/stylus"), {0.0, 0.0, -force});
    for (int i = 0; i < 500; ++i) ASSERT_TRUE(world.step());
    const double pressed = force + 0.0162 * 9.81;  // the stylus lies on the spring too
    const double wanted = std::max(0.0, pressed - kPreload) / kStiffness;
    EXPECT_NEAR(plunge(world), wanted, 0.01 * wanted + 1e-6) << force << " N";
  }
}

TEST(Springs, AStiffSpringOnALightTipIsStable) {
  WorldDescription description = standing_probe();
  for (auto& joint : description.robots[0].joints) {
    if (joint.joint == "plunge") joint.spring->stiffness = 1e7;
  }
  World world = make(description);
  world.push(world.body("probe/stylus"), {0.0, 0.0, -20.0});
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(world.step());
    ASSERT_LT(std::abs(plunge(world)), 1e-5) << "step " << i;
  }
}

TEST(Springs, RefuseNonsense) {
  WorldDescription description = standing_probe();
  description.robots[0].joints[0].spring->stiffness = 0.0;
  const auto world = World::create(description);
  ASSERT_FALSE(world);
  EXPECT_THAT(world.error(), takt::test::Reports(Code::kOutOfRange, "/robots/probe", {"plunge", "0"}));
}

}  // namespace
}  // namespace takt::sim::test
