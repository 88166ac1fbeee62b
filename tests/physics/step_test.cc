// One world, one step: what touches nothing changes nothing, pushes act in full, and smaller steps lead to the truth.
#include <cmath>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "sim/contact/contact_law.h"
#include "tests/physics/parts.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

ObjectDescription far_screw() {
  ObjectDescription screw = part("far", kinematics::Cylinder{0.003, 0.012}, 0.003, {300.0, 0.0, 50.0});
  screw.screw = ScrewDescription{
      .thread =
          {.size = "M6", .pitch = 0.001, .major = 0.006, .pitch_diameter = 0.00535, .run_down = 0.01, .friction = 0.12},
      .X_OT = Pose(Eigen::Translation3d(0.0, 0.0, -0.006))};
  return screw;
}

/// A ball that bounces, a block that sticks, one that slides, and a box that tumbles onto its edges.
WorldDescription cell() {
  WorldDescription description;
  description.physics.gravity = gravity_on_slope(0.4);
  description.objects.push_back(ground());
  description.objects.push_back(part("ball", kinematics::Sphere{0.05}, 1.0, {0.0, 0.0, 0.4}));
  description.objects.push_back(part("block", kinematics::Box{{0.1, 0.1, 0.1}}, 7.85, {0.0, 1.0, 0.05}));
  description.objects.push_back(part("slider", kinematics::Box{{0.1, 0.1, 0.05}}, 1.0, {0.0, 2.0, 0.025}));
  description.objects.push_back(part("tumbler", kinematics::Box{{0.2, 0.04, 0.02}}, 0.5, {0.0, 3.0, 0.3}));
  description.objects.back().mount.X_P.linear() = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).matrix();
  return description;
}

TEST(Step, WhatTouchesNothingChangesNothing) {
  WorldDescription with_screw = cell();
  with_screw.objects.push_back(far_screw());
  World alone = built(cell()), beside = built(with_screw);
  const auto count = static_cast<std::size_t>(alone.physics_model()->nq);
  for (int i = 0; i < 3000; ++i) {
    ASSERT_TRUE(alone.step() && beside.step());
    for (std::size_t k = 0; k < count; ++k)
      ASSERT_EQ(alone.positions()[k], beside.positions()[k]) << alone.position_names()[k] << " at " << i << " ms";
  }
}

TEST(Step, APartThatSleepsKeepsTheWholeImpulseOfAPush) {
  const auto pushed = [](bool rest) {
    WorldDescription description;
    description.physics.rest = rest;
    description.objects.push_back(ground(with_friction(0.0)));
    description.objects.push_back(part("part", kinematics::Box{{0.1, 0.1, 0.05}}, 1.0, {0.0, 0.0, 0.025}));
    description.objects.back().contact.friction = 0.0;
    World world = built(description);
    run_for(world, 1.0);
    EXPECT_EQ(world.physics_data()->body_awake[world.body("part")] == mjS_ASLEEP, rest);
    const double begin = place_of(world, "part").x();
    world.push(world.body("part"), {100.0, 0.0, 0.0});
    run_for(world, 0.002);
    world.push(world.body("part"), Vector3d::Zero());
    run_for(world, 0.5);
    return place_of(world, "part").x() - begin;
  };
  EXPECT_NEAR(pushed(true), pushed(false), 1e-6);
  EXPECT_NEAR(pushed(true), 0.2 * 0.5, 0.002);
}

/// Speed after over speed before, of a ball that falls onto a spring and a damper.
double restitution(double damping_ratio, Nanoseconds timestep) {
  const double mass = 1.0, stiffness = 1e4;
  ContactParameters surface = with_friction(0.0);
  surface.own_stiffness = true;
  surface.stiffness = stiffness;
  surface.damping = 2.0 * damping_ratio * std::sqrt(stiffness * mass);
  WorldDescription description;
  description.physics.timestep = timestep;
  description.physics.gravity.setZero();
  description.objects.push_back(ground(surface));
  description.objects.push_back(part("part", kinematics::Sphere{0.05}, mass, {0.0, 0.0, 0.1}));
  description.objects.back().contact = surface;
  World world = built(description);
  world.push(world.body("part"), {0.0, 0.0, -100.0});
  run_for(world, 0.01);
  world.push(world.body("part"), Vector3d::Zero());
  run_for(world, 0.3);
  const double begin = place_of(world, "part").z();
  run_for(world, 0.1);
  return (place_of(world, "part").z() - begin) / 0.1;
}

/// Of a spring and a damper that push only: it parts when the force is gone, not when the spring is.
double restitution_of(double z) {
  const double root = std::sqrt(1.0 - z * z);
  const double time = std::atan2(2.0 * z * root, 2.0 * z * z - 1.0) / root;  // times the frequency
  return std::exp(-z * time);
}

TEST(Step, SmallerStepsLeadToTheRestitutionOfSpringAndDamper) {
  for (const double ratio : {0.05, 0.2}) {
    const double truth = restitution_of(ratio);
    const auto error = [&](Nanoseconds timestep) { return std::abs(restitution(ratio, timestep) - truth) / truth; };
    EXPECT_LT(error(kMillisecond), 0.02) << ratio;
    EXPECT_LT(error(kMillisecond / 2), 0.01) << ratio;
    EXPECT_LT(error(kMillisecond / 4), 0.005) << ratio;
  }
}

}  // namespace
}  // namespace takt::sim::test
