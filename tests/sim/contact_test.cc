// Contacts in an engineer's units: what a spring, a damper and dry friction do, whatever the masses.
#include "sim/contact/contact_law.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/sim/cell.h"
#include "tests/support/allocation_guard.h"

namespace takt::sim::test {
namespace {

constexpr double kG = 9.81;
constexpr double kHalf = 0.02;  // m, of a part

ObjectDescription plate(const ContactParameters& surface = {}) {
  ObjectDescription object = box("plate", {4.0, 4.0, 0.1}, {0.0, 0.0, -0.05});
  object.contact = surface;
  return object;
}

ObjectDescription free_part(const std::string& name, const ObjectShape& shape, double mass, double height,
                            const ContactParameters& surface = {}) {
  ObjectDescription object;
  object.name = name;
  object.shapes.push_back({.shape = shape});
  object.mount.X_P.translation().z() = height;
  object.free = true;
  object.mass = mass;
  object.contact = surface;
  return object;
}

const ObjectShape kCube = kinematics::Box{{2 * kHalf, 2 * kHalf, 2 * kHalf}};
const ObjectShape kSlab = kinematics::Box{{2 * kHalf, 2 * kHalf, 0.5 * kHalf}};

WorldDescription on_plate(const ObjectShape& shape, double mass, double height, const ContactParameters& surface = {}) {
  WorldDescription world;
  world.objects.push_back(plate(surface));
  world.objects.push_back(free_part("part", shape, mass, height, surface));
  return world;
}

void steps(World& world, int count) {
  for (int i = 0; i < count; ++i) ASSERT_TRUE(world.step());
}

Eigen::Vector3d at(const World& world, const std::string& name = "part") {
  return world.body_pose(world.body(name)).translation();
}

TEST(ContactLaw, PartsOfAnyMassSinkInByForceOverStiffness) {
  for (const double stiffness : {1e4, 3e5, 2e6}) {
    ContactParameters surface;
    surface.stiffness = stiffness;
    surface.damping = 0.002 * stiffness;
    surface.own_stiffness = true;
    for (const double mass : {0.001, 0.1, 10.0}) {
      for (const ObjectShape& shape : {kCube, ObjectShape(kinematics::Sphere{kHalf})}) {
        World world = make(on_plate(shape, mass, kHalf, surface));
        steps(world, 4000);
        const double wanted = mass * kG / stiffness;
        EXPECT_NEAR(kHalf - at(world).z(), wanted, 0.05 * wanted) << stiffness << " N/m, " << mass << " kg";
      }
    }
  }
}

TEST(ContactLaw, SlidingKeepsContact) {
  for (const double mass : {0.1, 10.0}) {
    for (const double speed : {0.005, 0.02, 0.1}) {
      World world = make(on_plate(kSlab, mass, 0.25 * kHalf));
      const std::size_t watch = *world.watch_contact("part", "plate");
      const double friction = 0.6;
      steps(world, 200);
      double before = at(world).x(), moved = 0.0, sum = 0.0;
      int lost = 0;
      for (int i = 0; i < 2000; ++i) {
        const double ramp = std::min(1.0, i / 300.0);
        const double pull = friction * mass * kG * ramp + mass * 100.0 * (speed * ramp - 1000.0 * moved);
        world.push(world.body("part"), {pull, 0.0, 0.0});
        steps(world, 1);
        moved = at(world).x() - before;
        before += moved;
        if (i < 1000) continue;
        const double force = world.contact(watch).force / std::hypot(1.0, friction);
        sum += force;
        lost += force <= 0.0 ? 1 : 0;
      }
      EXPECT_EQ(lost, 0) << mass << " kg, " << speed << " m/s";
      EXPECT_NEAR(sum / 1000.0, mass * kG, 0.02 * mass * kG) << mass << " kg, " << speed << " m/s";
      // Below: docs/contacts.md, "Limits".
      if (speed > 0.01) {
        EXPECT_NEAR(1000.0 * moved, speed, 0.02 * speed);
      }
    }
  }
}

TEST(ContactLaw, FrictionBrakesAsCoulombSays) {
  for (const double mass : {0.1, 1.0}) {
    World world = make(on_plate(kSlab, mass, 0.25 * kHalf));
    steps(world, 300);
    const double force = 4.0 * mass * kG, friction = 0.6;
    world.push(world.body("part"), {force, 0.0, 0.0});
    const double begin = at(world).x();
    steps(world, 50);
    const double pushed = at(world).x() - begin;
    world.push(world.body("part"), {0.0, 0.0, 0.0});
    steps(world, 1000);
    // The work of the push is that of friction over the whole way.
    EXPECT_NEAR(at(world).x() - begin, force * pushed / (friction * mass * kG),
                0.05 * force * pushed / (0.6 * mass * kG));
  }
}

TEST(ContactLaw, NothingCreepsOnASlope) {
  for (const double mass : {0.1, 10.0}) {
    WorldDescription description = on_plate(kSlab, mass, 0.25 * kHalf);
    const double angle = 25.0 * std::numbers::pi / 180.0;
    description.physics.gravity = {kG * std::sin(angle), 0.0, -kG * std::cos(angle)};
    World world = make(description);
    steps(world, 500);
    const Eigen::Vector3d before = at(world);
    steps(world, 10'000);
    EXPECT_LT((at(world) - before).norm(), 1e-6) << mass << " kg";
  }
}

TEST(ContactLaw, AStackOfTenStandsForAMinute) {
  WorldDescription description;
  description.objects.push_back(plate());
  for (int i = 0; i < 10; ++i)
    description.objects.push_back(free_part("part" + std::to_string(i), kCube, 0.1, kHalf * (2 * i + 1)));
  World world = make(description);
  steps(world, 2000);
  std::vector<Eigen::Vector3d> before;
  for (int i = 0; i < 10; ++i) before.push_back(at(world, "part" + std::to_string(i)));
  steps(world, 60'000);
  for (int i = 0; i < 10; ++i)
    EXPECT_LT((at(world, "part" + std::to_string(i)) - before[static_cast<std::size_t>(i)]).norm(), 5e-6);
}

TEST(ContactLaw, PairsFollowTheRules) {
  ContactParameters steel, rubber, spring;
  steel.material = "steel";
  steel.stiffness = 6e5;
  steel.damping = 1200;
  rubber = {.material = "rubber", .stiffness = 3e5, .damping = 300, .friction = 0.8};
  spring = {.material = "steel", .stiffness = 1e4, .damping = 20, .friction = 0.2, .own_stiffness = true};
  const ContactPair series = combine(steel, rubber, {});
  EXPECT_NEAR(series.stiffness, 2e5, 1.0);
  EXPECT_NEAR(series.damping, 1200.0 / 9.0 + 300.0 * 4.0 / 9.0, 1e-9);
  EXPECT_EQ(series.friction, 0.8);
  EXPECT_EQ(combine(steel, spring, {}).stiffness, 1e4);
  EXPECT_EQ(combine(steel, spring, {}).damping, 20);
  const std::vector<ContactRule> rules{{.between = {"rubber", "steel"}, .stiffness = 7e4, .friction = 0.1}};
  EXPECT_EQ(combine(steel, rubber, rules).stiffness, 7e4);
  EXPECT_EQ(combine(steel, rubber, rules).friction, 0.1);
  EXPECT_EQ(combine(spring, rubber, rules).stiffness, 1e4) << "a stiffness of its own counts";
  EXPECT_EQ(combine(spring, rubber, rules).friction, 0.1);
}

TEST(ContactLaw, ASnapshotRemembersFriction) {
  WorldDescription description = on_plate(kSlab, 1.0, 0.25 * kHalf);
  description.physics.gravity = {3.0, 0.0, -kG};
  World world = make(description);
  steps(world, 500);
  const Snapshot snapshot = world.save();
  steps(world, 100);
  const Eigen::Vector3d on = at(world);
  ASSERT_TRUE(world.restore(snapshot));
  steps(world, 100);
  EXPECT_EQ(at(world), on);
}

/// A slab of `pieces`, end to end, on a row of posts.
WorldDescription slab_on_posts(int pieces, int posts) {
  constexpr double kEvery = 0.03;
  WorldDescription world;
  ObjectDescription slab = free_part("slab", kSlab, 1.0, 0.25 * kHalf);
  slab.shapes.clear();
  const double length = kEvery * posts;
  for (int i = 0; i < pieces; ++i) {
    ObjectGeometry piece{.shape = kinematics::Box{{length / pieces, 0.1, 0.5 * kHalf}}};
    piece.X_OG.translation().x() = length * ((i + 0.5) / pieces - 0.5);
    slab.shapes.push_back(piece);
  }
  world.objects.push_back(slab);
  for (int i = 0; i < posts; ++i)
    world.objects.push_back(
        box("post" + std::to_string(i), {0.01, 0.1, 0.1}, {kEvery * (i + 0.5) - 0.5 * length, 0.0, -0.05}));
  return world;
}

TEST(ContactLaw, TellsWhenMoreTouchesThanItRemembers) {
  World few = make(slab_on_posts(1, 12));
  World many = make(slab_on_posts(1, 13));
  World pieces = make(slab_on_posts(13, 13));
  for (World* world : {&few, &many, &pieces}) steps(*world, 10);
  EXPECT_EQ(few.contact_law().forgotten(), 0);
  EXPECT_EQ(few.contact_law().capacity(), 12u);
  EXPECT_GE(many.contact_law().forgotten(), 10);
  EXPECT_EQ(pieces.contact_law().forgotten(), 0);
}

TEST(ContactLaw, DoesNotAllocate) {
  World world = make(on_plate(kSlab, 1.0, 0.25 * kHalf));
  steps(world, 100);
  takt::test::AllocationGuard guard;
  for (int i = 0; i < 100; ++i) (void)world.step();
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace takt::sim::test
