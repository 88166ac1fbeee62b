// Static friction: below its limit nothing moves, however the contact points share the load.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sim/contact/contact_law.h"
#include "tests/physics/parts.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kStictionMu = 0.6;

/// What force does to two such surfaces.
double depth_of(double force) { return force / combine(ContactParameters{}, ContactParameters{}, {}).stiffness; }
/// Along each other: what holds below the limit gives elastically.
double give(double force) { return depth_of(force) / 0.8; }

struct Creep {
  double slip = 0.0;   ///< m, of its foot, until it sticks, beyond the elastic give
  double speed = 0.0;  ///< m/s, afterwards
};

/// On a slope that takes that share of what friction holds; nothing may sleep.
Creep creep_of(ObjectDescription object, double height, double share) {
  const double angle = std::atan(share * kStictionMu);
  WorldDescription description;
  description.physics.rest = false;
  description.physics.gravity = gravity_on_slope(angle);
  description.objects.push_back(ground());
  object.mount.X_P.translation().z() = height - depth_of(object.mass * kGravity * std::cos(angle));
  description.objects.push_back(object);
  World world = built(description);
  // It leans on its springs: what slips is its foot.
  const auto foot = [&] { return Vector3d(world.body_pose(world.body("part")) * Vector3d(0.0, 0.0, -height)); };
  run_for(world, 4.0);
  const Vector3d early = foot();
  run_for(world, 3.0);
  const Vector3d late = foot();
  return {early.x() - give(object.mass * kGravity * std::sin(angle)), (late - early).norm() / 3.0};
}

ObjectDescription block(const Vector3d& size, double mass) {
  return part("part", kinematics::Box{size}, mass, Vector3d::Zero());
}

constexpr double kMostCreep = 1e-6;  ///< m/s
constexpr double kMostSlip = 5e-4;   ///< m, until it sticks

TEST(Stiction, NothingCreepsBelowTheLimit) {
  for (const double mass : {0.1, 1.0, 7.85, 20.0, 50.0}) {
    for (const double share : {0.7, 0.9, 0.95}) {
      const Creep cube = creep_of(block({0.1, 0.1, 0.1}, mass), 0.05, share);
      EXPECT_LT(cube.speed, kMostCreep) << "cube, " << mass << " kg, " << share;
      EXPECT_LT(cube.slip, kMostSlip) << "cube, " << mass << " kg, " << share;
      const Creep flat = creep_of(block({0.2, 0.2, 0.02}, mass), 0.01, share);
      EXPECT_LT(flat.speed, kMostCreep) << "flat, " << mass << " kg, " << share;
      EXPECT_LT(flat.slip, kMostSlip) << "flat, " << mass << " kg, " << share;
    }
    for (const double share : {0.7, 0.9}) {
      const Creep tall = creep_of(block({0.1, 0.1, 0.16}, mass), 0.08, share);
      EXPECT_LT(tall.speed, kMostCreep) << "tall, " << mass << " kg, " << share;
      EXPECT_LT(tall.slip, kMostSlip) << "tall, " << mass << " kg, " << share;
    }
  }
}

TEST(Stiction, ACylinderAndATripodHoldToo) {
  for (const double share : {0.5, 0.7, 0.9}) {
    const Creep cylinder =
        creep_of(part("part", kinematics::Cylinder{0.04, 0.06}, 2.37, Vector3d::Zero()), 0.03, share);
    EXPECT_LT(cylinder.speed, kMostCreep) << share;
    EXPECT_LT(cylinder.slip, kMostSlip) << share;
    ObjectDescription tripod = part("part", kinematics::Box{{0.25, 0.25, 0.2}}, 0.0, Vector3d::Zero());
    tripod.shapes.front().mass = 27.0;
    tripod.shapes.front().X_OG.translation().z() = 0.02;
    for (int foot = 0; foot < 3; ++foot) {
      const double angle = 2.0 * M_PI / 3.0 * foot;
      ObjectGeometry ball{.shape = kinematics::Sphere{0.02}, .mass = 1.0};
      ball.X_OG.translation() = Vector3d(0.15 * std::cos(angle), 0.15 * std::sin(angle), -0.1);
      tripod.shapes.push_back(ball);
    }
    tripod.mass = 30.0;
    const Creep stands = creep_of(tripod, 0.12, share);
    EXPECT_LT(stands.speed, kMostCreep) << share;
    EXPECT_LT(stands.slip, kMostSlip) << share;
  }
}

TEST(Stiction, ATwistBesideThePushHoldsAsLongAsThePatchCan) {
  // Pushed at its edge: force and torque together take three quarters of what four corners can hold.
  for (const double mass : {0.1, 1.0, 20.0}) {
    WorldDescription description;
    description.physics.rest = false;
    description.objects.push_back(ground());
    description.objects.push_back(block({0.1, 0.1, 0.02}, mass));
    description.objects.back().mount.X_P.translation().z() = 0.01;
    World world = built(description);
    run_for(world, 0.5);
    const double limit = kStictionMu * mass * kGravity, radius = 0.05 * std::sqrt(2.0);
    world.push(world.body("part"), {0.5 * limit, 0.0, 0.0}, {0.0, 0.0, 0.5 * limit * radius});
    run_for(world, 1.0);
    const Eigen::Isometry3d before = world.body_pose(world.body("part"));
    run_for(world, 3.0);
    const Eigen::Isometry3d moved = before.inverse() * world.body_pose(world.body("part"));
    EXPECT_LT(moved.translation().norm(), 3e-6) << mass;
    EXPECT_LT(Eigen::AngleAxisd(moved.linear()).angle(), 3e-5) << mass;
  }
}

TEST(Stiction, WhatIsShakenBelowTheLimitStays) {
  for (const double mass : {0.1, 1.0, 7.85, 20.0, 50.0}) {
    WorldDescription description;
    description.physics.rest = false;
    description.physics.gravity = gravity_on_slope(std::atan(0.7 * kStictionMu));
    description.objects.push_back(ground());
    description.objects.push_back(block({0.1, 0.1, 0.1}, mass));
    description.objects.back().mount.X_P.translation().z() = 0.05;
    World world = built(description);
    run_for(world, 1.0);
    const Vector3d before = place_of(world, "part");
    const double limit = kStictionMu * mass * kGravity * std::cos(std::atan(0.7 * kStictionMu));
    // 25 Hz along and across, in all at most nine tenths of the limit. At first what it leaned on gives way a little.
    Vector3d shaken = before;
    for (int i = 0; i < 6000; ++i) {
      if (i == 3000) shaken = place_of(world, "part");
      const double phase = 2.0 * M_PI * 25.0 * 0.001 * i;
      world.push(world.body("part"), {0.18 * limit * std::sin(phase), 0.2 * limit * std::cos(phase), 0.0});
      ASSERT_TRUE(world.step());
    }
    EXPECT_LT((place_of(world, "part") - shaken).norm(), 3.0 * kMostCreep) << mass << " kg";
    world.push(world.body("part"), Vector3d::Zero());
    run_for(world, 0.5);
    EXPECT_LT((place_of(world, "part") - before).norm(), 5e-5) << mass << " kg";
  }
}

TEST(Stiction, BeyondTheLimitItSlides) {
  for (const double mass : {0.1, 1.0, 20.0}) {
    const double share = 1.05, angle = std::atan(share * kStictionMu);
    const Creep creep = creep_of(block({0.1, 0.1, 0.1}, mass), 0.05, share);
    // The mean speed of the seconds 4 to 7.
    const double expected = 5.5 * kGravity * (std::sin(angle) - kStictionMu * std::cos(angle));
    EXPECT_NEAR(creep.speed, expected, 0.1 * expected) << mass;
  }
}

}  // namespace
}  // namespace takt::sim::test
