// Joints that a spring holds: a sprung probe gives way by force over stiffness, and comes back.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

constexpr double kStiffness = 20'000.0, kPreload = 1.0;

/// A probe that stands on the world with its stylus upwards, and a block of a mass above its ball.
WorldDescription pressed_probe(double mass) {
  WorldDescription world;
  RobotDescription probe;
  probe.name = "probe";
  probe.model = model("probe_sprung");
  probe.joints.push_back(
      {.joint = "plunge", .spring = JointSpring{.stiffness = kStiffness, .damping = 20.0, .preload = kPreload}});
  world.robots.push_back(probe);
  ObjectDescription block = box("block", {0.04, 0.04, 0.02}, {0.0, 0.0, 0.1255});
  block.free = true;
  block.mass = mass;
  world.objects.push_back(block);
  // A block on a ball falls off: it is guided by nothing, but a wide patch of rubber holds it upright for a while.
  world.objects.back().contact.torsion = 0.01;
  world.objects.back().contact.rolling = 0.02;
  return world;
}

double plunge(const World& world) { return world.positions()[0]; }

TEST(Springs, GiveWayByForceOverStiffnessBeyondThePreload) {
  for (const double mass : {0.05, 0.5, 2.0}) {
    World world = make(pressed_probe(mass));
    for (int i = 0; i < 400; ++i) ASSERT_TRUE(world.step());
    const double force = (mass + 0.0162) * 9.81;  // the stylus lies on the spring too
    const double wanted = std::max(0.0, force - kPreload) / kStiffness;
    EXPECT_NEAR(plunge(world), wanted, 0.05 * wanted + 1e-6) << mass << " kg";
  }
}

TEST(Springs, AStiffSpringOnALightTipIsStable) {
  WorldDescription description = pressed_probe(0.5);
  description.robots[0].joints[0].spring->stiffness = 1e6;
  World world = make(description);
  double highest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(world.step());
    highest = std::max(highest, std::abs(plunge(world)));
  }
  EXPECT_LT(highest, 1e-4);
}

TEST(Springs, RefuseNonsense) {
  WorldDescription description = pressed_probe(0.5);
  description.robots[0].joints[0].spring->stiffness = 0.0;
  const auto world = World::create(description);
  ASSERT_FALSE(world);
  EXPECT_NE(world.error().to_string().find("stiffness of 'plunge'"), std::string::npos);
}

}  // namespace
}  // namespace takt::sim::test
