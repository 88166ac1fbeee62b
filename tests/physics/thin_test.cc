// What is small and fast does not pass through what is thin.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/physics/parts.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

/// A sheet of 1 mm, upright at x = 0, that stands still, and what flies at it from 0.3 m away without gravity.
WorldDescription sheet_and(const ObjectShape& shape, double mass) {
  WorldDescription description;
  description.physics.gravity.setZero();
  ObjectDescription sheet;
  sheet.name = "sheet";
  sheet.shapes.push_back({kinematics::Box{{0.001, 0.4, 0.4}}});
  description.objects.push_back(sheet);
  description.objects.push_back(part("part", shape, mass, {-0.3, 0.0, 0.0}));
  return description;
}

/// @return x at the end; > 0: it has passed through
double thrown(const WorldDescription& description, double speed, double mass) {
  World world = built(description);
  // In one step it has that speed.
  world.push(world.body("part"), {mass * speed / 1e-3, 0.0, 0.0});
  run_for(world, 1e-3);
  world.push(world.body("part"), Vector3d::Zero());
  run_for(world, 0.6 / speed + 0.05);
  return place_of(world, "part").x();
}

TEST(Thin, WhatIsFastIsStopped) {
  struct Case {
    const char* name;
    ObjectShape shape;
    double mass;
  };
  for (const Case& one : {Case{"nut", kinematics::Cylinder{0.005, 0.005}, 0.003},
                          {"ball", kinematics::Sphere{0.003}, 0.001},
                          {"key", kinematics::Box{{0.05, 0.005, 0.005}}, 0.01},
                          {"cube", kinematics::Box{{0.02, 0.02, 0.02}}, 0.06}}) {
    for (const double speed : {1.0, 5.0, 10.0, 20.0, 50.0}) {
      const double end = thrown(sheet_and(one.shape, one.mass), speed, one.mass);
      EXPECT_LT(end, 0.0) << one.name << " with " << speed << " m/s";
    }
  }
}

TEST(Thin, WhatMeetsNothingFliesOn) {
  WorldDescription description = sheet_and(kinematics::Sphere{0.003}, 0.001);
  description.objects.front().mount.X_P.translation().y() = 1.0;
  const double speed = 20.0;
  World world = built(description);
  world.push(world.body("part"), {0.001 * speed / 1e-3, 0.0, 0.0});
  run_for(world, 1e-3);
  world.push(world.body("part"), Vector3d::Zero());
  const double begin = place_of(world, "part").x();
  run_for(world, 0.1);
  EXPECT_NEAR(place_of(world, "part").x() - begin, 0.1 * speed, 1e-6);
}

/// A sheet that flies ahead as fast is no wall, though the part goes twice the gap in a step.
TEST(Thin, WhatMovesAlongIsNoWall) {
  constexpr double kMass = 0.001, kSpeed = 20.0, kPush = 0.04;
  WorldDescription description = sheet_and(kinematics::Sphere{0.003}, kMass);
  ObjectDescription& sheet = description.objects.front();
  sheet.free = true;
  sheet.mass = 1.0;
  sheet.mount.X_P.translation().x() = -0.29;
  World world = built(description);
  world.push(world.body("part"), {kMass * kSpeed / kPush, 0.0, 0.0});
  world.push(world.body("sheet"), {kSpeed / kPush, 0.0, 0.0});
  run_for(world, kPush);
  world.push(world.body("part"), Vector3d::Zero());
  world.push(world.body("sheet"), Vector3d::Zero());
  run_for(world, 0.1);
  EXPECT_NEAR(place_of(world, "sheet").x() - place_of(world, "part").x(), 0.01, 1e-6);
  EXPECT_GT(place_of(world, "part").x(), 1.5);
}

/// A peg that is shot into a bore goes in.
TEST(Thin, ABoreIsOpen) {
  WorldDescription description = sheet_and(kinematics::Sphere{0.003}, 0.001);
  ObjectDescription& block = description.objects.front();
  block.shapes.front().shape = kinematics::Box{{0.4, 0.4, 0.05}};
  world::Bore bore;
  bore.radius = 0.01;
  bore.X_SB.translation() = Vector3d(0.0, 0.0, 0.025);
  block.shapes.front().bores.push_back(bore);
  block.mount.X_P.linear() = Eigen::AngleAxisd(-M_PI / 2.0, Vector3d::UnitY()).matrix();
  EXPECT_GT(thrown(description, 20.0, 0.001), 0.1);
}

}  // namespace
}  // namespace takt::sim::test
