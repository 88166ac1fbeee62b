// Bores and pegs: what springs, friction and balances of forces say, in any direction of the room.
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "sim/contact/solid_mesh.h"
#include "tests/sim/cell.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/reports.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kEarth = 9.81;
constexpr double kBoreRadius = 0.01515, kPegRadius = 0.015, kBoreDepth = 0.04, kPegLength = 0.06, kPegMass = 0.3;
constexpr double kStiff = 3e5;  // N/m

ContactParameters bored_surface(double friction) {
  ContactParameters made;
  made.stiffness = kStiff;
  made.damping = 600.0;
  made.friction = friction;
  made.own_stiffness = made.own_friction = true;
  return made;
}

/// A block whose upper face is at z = 0, with a bore in the middle.
ObjectDescription block_with_bore(double radius, double chamfer, double friction) {
  ObjectDescription object = box("block", {0.1, 0.1, 0.05}, {0.0, 0.0, -0.025});
  world::Bore bore{.radius = radius, .depth = kBoreDepth, .chamfer = chamfer};
  bore.X_SB.translation().z() = 0.025;
  object.shapes[0].bores.push_back(bore);
  object.contact = bored_surface(friction);
  return object;
}

/// A cylinder about z with its lower end at this height.
ObjectDescription round_peg(double end, double friction, double length = kPegLength) {
  ObjectDescription object;
  object.name = "peg";
  object.shapes.push_back({.shape = kinematics::Cylinder{kPegRadius, length}, .chamfer = 0.001});
  object.mount.X_P.translation().z() = end + 0.5 * length;
  object.free = true;
  object.mass = kPegMass;
  object.contact = bored_surface(friction);
  return object;
}

struct Inserted {
  World world;
  int peg;
  std::size_t watch;
};

Inserted inserted(WorldDescription description) {
  World world = make(description);
  const int peg = world.body("peg");
  const std::size_t watch = *world.watch_contact("peg", "block");
  return {std::move(world), peg, watch};
}

WorldDescription peg_over_bore(double end, double friction, double length = kPegLength, double chamfer = 0.001) {
  WorldDescription world;
  world.objects.push_back(block_with_bore(kBoreRadius, chamfer, friction));
  world.objects.push_back(round_peg(end, friction, length));
  return world;
}

void advance(World& world, int count) {
  for (int i = 0; i < count; ++i) ASSERT_TRUE(world.step());
}

double lean(const Pose& X_WP) { return std::acos(std::min(1.0, X_WP.linear()(2, 2))); }

TEST(Bore, APegFallsInAndRestsOnTheBottom) {
  auto [world, peg, watch] = inserted(peg_over_bore(0.002, 0.2));
  advance(world, 3000);
  const Pose X = world.body_pose(peg);
  const double end = X.translation().z() - 0.5 * kPegLength;
  EXPECT_NEAR(end, -kBoreDepth - kPegMass * kEarth / kStiff, 1e-6);
  EXPECT_NEAR(world.contact(watch).force, kPegMass * kEarth, 0.001 * kPegMass * kEarth);
  EXPECT_LT(X.translation().head<2>().norm(), kBoreRadius - kPegRadius + 1e-5);
}

TEST(Bore, TheWallAnswersAtEachEndOfThePeg) {
  WorldDescription description = peg_over_bore(-0.039, 0.0, 0.03);
  description.physics.gravity.setZero();
  auto [world, peg, watch] = inserted(description);
  for (const double force : {5.0, 20.0, 40.0}) {
    world.push(peg, {force, 0.0, 0.0});
    advance(world, 1500);
    const Pose X = world.body_pose(peg);
    const double wanted = kBoreRadius - kPegRadius + force / (2.0 * kStiff);
    EXPECT_NEAR(X.translation().x(), wanted, 1e-7) << force;
    EXPECT_NEAR(world.contact(watch).force, force, 0.001 * force);
    EXPECT_LT(lean(X), 1e-6);
  }
}

TEST(Bore, NothingPushesWhileAPegSlidesAlongTheWall) {
  WorldDescription description = peg_over_bore(-0.039, 0.0, 0.03);
  description.physics.gravity.setZero();
  auto [world, peg, watch] = inserted(description);
  world.push(peg, {20.0, 0.0, 0.0});
  advance(world, 1500);
  // Once around the wall in four seconds, and a little up and down.
  double least = 1e9, most = 0.0, along = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 4000.0;
    world.push(peg, {20.0 * std::cos(angle), 20.0 * std::sin(angle), kPegMass * 0.02 * std::cos(4.0 * angle)});
    advance(world, 1);
    const ContactReading& reading = world.contact(watch);
    least = std::min(least, reading.force_W.head<2>().norm());
    most = std::max(most, reading.force_W.head<2>().norm());
    along = std::max(along, std::abs(reading.force_W.z()));
  }
  EXPECT_GT(least, 19.5);
  EXPECT_LT(most, 20.5);
  EXPECT_LT(along, 0.01);
}

/// A peg in its bore whose centre of mass, where pushes act, is in its upper part.
WorldDescription tall_peg(double end, double friction) {
  WorldDescription description = peg_over_bore(end, friction);
  description.physics.gravity.setZero();
  kinematics::Inertial& inertial = description.objects[1].inertial.emplace();
  inertial.mass = kPegMass;
  inertial.X_LC.translation().z() = 0.02;
  inertial.I_C = Vector3d(1e-4, 1e-4, 4e-5).asDiagonal();
  return description;
}

TEST(Bore, APegPushedAsideAboveTheMouthLeansAsTwoSpringsSay) {
  // With friction: without, the edge of the mouth pushes a leaning peg out.
  auto [world, peg, watch] = inserted(tall_peg(-0.035, 0.3));
  const double force = 10.0, inside = 0.035 - 0.001 - 0.001, above = 0.05 - 0.035;
  world.push(peg, {force, 0.0, 0.0});
  advance(world, 2000);
  const double at_bottom = force * (above + 0.001) / inside, at_mouth = force + at_bottom;
  const double wanted = (2.0 * (kBoreRadius - kPegRadius) + (at_bottom + at_mouth) / kStiff) / inside;
  EXPECT_NEAR(lean(world.body_pose(peg)), wanted, 0.03 * wanted);
  EXPECT_NEAR(world.contact(watch).force, force, 0.01 * force);
}

/// A peg pressed aside above the mouth is held by friction at two points, against a push along its axis.
double sinks(double friction, double push) {
  auto [world, peg, watch] = inserted(tall_peg(-0.025, friction));
  const double force = 10.0;
  world.push(peg, {force, 0.0, 0.0});
  advance(world, 1000);
  const double before = world.body_pose(peg).translation().z();
  world.push(peg, {force, 0.0, -push});
  advance(world, 300);
  return before - world.body_pose(peg).translation().z();
}

TEST(Bore, ALeaningPegJamsAsFrictionSays) {
  // Both points carry: N at the bottom, N + F at the mouth; they hold mu (2 N + F).
  const double inside = 0.025 - 0.002, above = 0.05 - 0.025;
  const double friction = 0.3, hold = friction * (10.0 + 2.0 * 10.0 * (above + 0.001) / inside);
  // Friction's springs give way by about 0.2 mm before they slip.
  EXPECT_LT(sinks(friction, 0.85 * hold), 5e-4);
  EXPECT_GT(sinks(friction, 1.2 * hold), 3e-3);
  EXPECT_GT(sinks(0.0, 5.0), 3e-3);
}

TEST(Bore, EnergyIsNotCreatedByAPegThatFallsIn) {
  auto [world, peg, watch] = inserted(peg_over_bore(0.004, 0.2));
  const double begin = world.energy();
  for (int i = 0; i < 1500; ++i) {
    advance(world, 1);
    ASSERT_LT(world.energy(), begin + 1e-5);
  }
  EXPECT_LT(world.energy(), begin - 0.9 * kPegMass * kEarth * 0.044);
}

/// Dropped by 4 mm onto the mouth, beside it and askew: it tumbles, wedges, slides in or falls over.
TEST(Bore, EnergyIsNotCreatedByAPegThatTumbles) {
  for (const double friction : {0.0, 0.2}) {
    for (int i = 0; i < 12; ++i) {
      WorldDescription description = peg_over_bore(0.004, friction);
      Pose& X_W = description.objects[1].mount.X_P;
      X_W.translation().x() = 0.01 * i / 11.0;
      X_W.linear() = Eigen::AngleAxisd(0.06 * ((5 * i) % 12) / 11.0, Vector3d::UnitY()).toRotationMatrix();
      auto [world, peg, watch] = inserted(description);
      const double begin = world.energy();
      double most = begin;
      for (int k = 0; k < 2000; ++k) {
        advance(world, 1);
        most = std::max(most, world.energy());
      }
      EXPECT_LT(most, begin + 1e-5) << "friction " << friction << ", peg " << i;
    }
  }
}

TEST(Bore, IsTheSameInEveryDirectionOfTheRoom) {
  const auto end = [](const Eigen::Quaterniond& turn) {
    WorldDescription description = peg_over_bore(0.002, 0.2);
    description.objects[1].mount.X_P.translation().x() = 0.0004;
    description.objects[1].mount.X_P.linear() = Eigen::AngleAxisd(0.02, Vector3d::UnitY()).toRotationMatrix();
    const Pose R(turn);
    for (ObjectDescription& object : description.objects) object.mount.X_P = R * object.mount.X_P;
    description.physics.gravity = turn * description.physics.gravity;
    auto [world, peg, watch] = inserted(description);
    advance(world, 150);
    return Pose(R.inverse() * world.body_pose(peg));
  };
  const Pose plain = end(Eigen::Quaterniond::Identity());
  ASSERT_LT(plain.translation().z(), 0.03) << "it has come into the bore";
  for (const double angle : {0.3, 1.1, 2.5}) {
    const Pose turned = end(Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector3d(1, -2, 0.5).normalized())));
    EXPECT_LT((turned.translation() - plain.translation()).norm(), 1e-6) << angle;
    EXPECT_LT((turned.linear() - plain.linear()).norm(), 1e-4) << angle;
  }
}

TEST(Bore, ABallRestsOnTheRimOfASmallerBore) {
  WorldDescription description;
  description.objects.push_back(block_with_bore(kBoreRadius, 0.0, 0.2));
  ObjectDescription ball;
  ball.name = "peg";
  ball.shapes.push_back({.shape = kinematics::Sphere{0.02}});
  ball.mount.X_P.translation() = Vector3d(0.001, 0.0, 0.021);
  ball.free = true;
  ball.mass = 0.2;
  ball.contact = bored_surface(0.2);
  description.objects.push_back(ball);
  auto [world, peg, watch] = inserted(description);
  advance(world, 4000);
  const Vector3d p = world.body_pose(peg).translation();
  EXPECT_NEAR(p.z(), std::sqrt(0.02 * 0.02 - kBoreRadius * kBoreRadius), 3e-5);
  EXPECT_LT(p.head<2>().norm(), 3e-5);
  EXPECT_NEAR(world.contact(watch).force, 0.2 * kEarth, 0.005 * 0.2 * kEarth);
}

TEST(Bore, APlateLiesOnTheFaceAroundIt) {
  WorldDescription description;
  description.objects.push_back(block_with_bore(kBoreRadius, 0.001, 0.5));
  ObjectDescription plate;
  plate.name = "peg";
  plate.shapes.push_back({.shape = kinematics::Box{{0.08, 0.08, 0.01}}});
  plate.mount.X_P.translation().z() = 0.005;
  plate.free = true;
  plate.mass = 0.5;
  plate.contact = bored_surface(0.5);
  description.objects.push_back(plate);
  auto [world, peg, watch] = inserted(description);
  advance(world, 2000);
  EXPECT_NEAR(world.body_pose(peg).translation().z(), 0.005 - 0.5 * kEarth / kStiff, 1e-6);
  EXPECT_LT(lean(world.body_pose(peg)), 1e-5);
  EXPECT_NEAR(world.contact(watch).force, 0.5 * kEarth, 0.005);
}

/// Two circles bear it, its own rim and the mouth, at four points each: as stiff as whole circles, whichever way it is
/// turned, and the lean is that of two rings of springs.
TEST(Bore, ADiscOverABoreLeansAlikeInEveryDirection) {
  constexpr double kMouth = 0.007, kRim = 0.014, kTorque = 4e-4;
  const double stiffness = kStiff * (kMouth * kMouth + kRim * kRim) / 4.0;
  for (const double angle : {0.0, 0.2, 0.5, 0.785, 1.3}) {
    WorldDescription description;
    description.objects.push_back(block_with_bore(kMouth - 0.001, 0.001, 0.3));
    description.objects.push_back(round_peg(0.0, 0.3, 0.02));
    Inserted disc = inserted(description);
    advance(disc.world, 500);
    disc.world.push(disc.peg, Vector3d::Zero(), kTorque * Vector3d(std::cos(angle), std::sin(angle), 0.0));
    advance(disc.world, 1000);
    EXPECT_EQ(disc.world.contact(disc.watch).contacts, 8);
    EXPECT_NEAR(disc.world.contact(disc.watch).force, kPegMass * kEarth, 1e-3);
    const double lean = disc.world.body_pose(disc.peg).linear().col(2).head<2>().norm();
    EXPECT_NEAR(lean, kTorque / stiffness, 0.02 * kTorque / stiffness) << angle;
  }
}

TEST(Bore, ATubeSlipsOverAPin) {
  WorldDescription description;
  ObjectDescription pin = box("block", {0.2, 0.2, 0.02}, {0.0, 0.0, -0.01});
  pin.shapes.push_back({.shape = kinematics::Cylinder{0.0149, 0.05}, .chamfer = 0.002});
  pin.shapes.back().X_OG.translation().z() = 0.035;  // above the middle of the base
  pin.contact = bored_surface(0.2);
  description.objects.push_back(pin);
  ObjectDescription tube;
  tube.name = "peg";
  tube.shapes.push_back({.shape = kinematics::Cylinder{0.025, 0.03}});
  world::Bore bore{.radius = 0.0152, .chamfer = 0.001};
  bore.X_SB.translation().z() = 0.015;
  tube.shapes[0].bores.push_back(bore);
  tube.mount.X_P.translation() = Vector3d(0.0002, -0.0001, 0.06);
  tube.free = true;
  tube.mass = 0.2;
  tube.contact = bored_surface(0.2);
  description.objects.push_back(tube);
  auto [world, peg, watch] = inserted(description);
  advance(world, 3000);
  EXPECT_NEAR(world.body_pose(peg).translation().z(), 0.015 - 0.2 * kEarth / kStiff, 3e-6);
  EXPECT_NEAR(world.contact(watch).force, 0.2 * kEarth, 0.01);
}

TEST(Bore, AStepAllocatesNothing) {
  auto [world, peg, watch] = inserted(peg_over_bore(-0.01, 0.2));
  world.push(peg, {5.0, 1.0, 0.0});
  advance(world, 50);
  takt::test::AllocationGuard guard;
  for (int i = 0; i < 100; ++i) (void)world.step();
  EXPECT_EQ(guard.count(), 0u);
}

TEST(Bore, ASnapshotGoesOnBitForBit) {
  auto [world, peg, watch] = inserted(peg_over_bore(0.002, 0.2));
  world.push(peg, {2.0, 1.0, 0.0});
  advance(world, 200);
  const Snapshot snapshot = world.save();
  advance(world, 100);
  const Snapshot wanted = world.save();
  ASSERT_TRUE(world.restore(snapshot));
  advance(world, 100);
  EXPECT_EQ(world.save(), wanted);
}

TEST(Bore, WhatCannotBeDrilledIsReported) {
  const auto found = [](const world::Bore& bore) {
    WorldDescription description;
    ObjectDescription object = box("block", {0.1, 0.1, 0.05}, {0.0, 0.0, 0.0});
    object.shapes[0].bores.push_back(bore);
    description.objects.push_back(object);
    auto world = World::create(description);
    return world ? Diagnostics{} : world.error();
  };
  world::Bore good{.radius = 0.01};
  good.X_SB.translation().z() = 0.025;
  EXPECT_FALSE(found(good).has_errors());
  const std::string at = "/objects/block/bores/0";
  const auto expect = [&](const world::Bore& bore, Code code) {
    EXPECT_THAT(found(bore), takt::test::Reports(code, at));
  };
  world::Bore bore = good;
  bore.X_SB.translation().z() = 0.02;
  expect(bore, Code::kInvalidValue);
  bore = good;
  bore.X_SB.rotate(Eigen::AngleAxisd(0.3, Vector3d::UnitX()));
  expect(bore, Code::kInvalidValue);
  bore = good;
  bore.X_SB.translation().x() = 0.045;
  expect(bore, Code::kInvalidValue);
  bore = good;
  bore.depth = 0.05;
  expect(bore, Code::kOutOfRange);
  bore = good;
  bore.radius = 0.0;
  expect(bore, Code::kOutOfRange);
  bore = good;
  bore.chamfer = 0.03;
  bore.radius = 0.005;
  expect(bore, Code::kOutOfRange);
}

TEST(Bore, APictureHasTheHole) {
  const std::vector<Eigen::Vector2d> square{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  std::vector<std::vector<Eigen::Vector2d>> holes(3);
  const std::vector<Eigen::Vector2d> centres{{-0.5, -0.5}, {0.5, 0.1}, {-0.4, 0.6}};
  double area = 4.0;
  for (std::size_t h = 0; h < holes.size(); ++h) {
    for (int i = 0; i < 24; ++i) {
      const double angle = -2.0 * std::numbers::pi * i / 24;
      holes[h].push_back(centres[h] + 0.3 * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    area -= 0.5 * 24 * 0.09 * std::sin(2.0 * std::numbers::pi / 24);
  }
  std::vector<Eigen::Vector2d> points = square;
  for (const auto& hole : holes) points.insert(points.end(), hole.begin(), hole.end());
  const std::vector<int> corners = triangulate(square, holes);
  double covered = 0.0;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const auto at = [&](std::size_t k) { return points[static_cast<std::size_t>(corners[i + k])]; };
    const Eigen::Vector2d a = at(1) - at(0), b = at(2) - at(0);
    const double piece = 0.5 * (a.x() * b.y() - a.y() * b.x());
    EXPECT_GT(piece, 0.0);
    covered += piece;
    // No triangle lies over a hole.
    const Eigen::Vector2d middle = (at(0) + at(1) + at(2)) / 3.0;
    for (const auto& centre : centres) EXPECT_GT((middle - centre).norm(), 0.29);
  }
  EXPECT_NEAR(covered, area, 1e-9);
}

}  // namespace
}  // namespace takt::sim::test
