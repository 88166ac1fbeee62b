// Free objects that lie still fall asleep: nothing that one can see may change by it, and whatever touches them wakes
// them.
#include "sim/contact/rest.h"

#include <cmath>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/device/base_description.h"
#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"
#include "tests/support/allocation_guard.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kEarthPull = 9.81;

ObjectDescription loose(const std::string& name, const Vector3d& size, const Vector3d& at, double mass) {
  ObjectDescription object = box(name, size, at);
  object.free = true;
  object.mass = mass;
  return object;
}

/// A plate, a stack of two cubes on it and a third cube beside, each a tenth of a millimetre above what it will lie on.
WorldDescription stack() {
  WorldDescription world;
  world.objects.push_back(box("plate", {1.0, 1.0, 0.1}, {0.0, 0.0, -0.05}));
  world.objects.push_back(loose("lower", {0.04, 0.04, 0.04}, {0.0, 0.0, 0.0201}, 0.5));
  world.objects.push_back(loose("upper", {0.04, 0.04, 0.04}, {0.005, 0.0, 0.0602}, 0.3));
  world.objects.push_back(loose("beside", {0.04, 0.04, 0.04}, {0.2, 0.0, 0.0201}, 0.4));
  return world;
}

WorldDescription awake(WorldDescription world) {
  world.physics.rest = false;
  return world;
}

void cycles(World& world, int count) {
  for (int i = 0; i < count; ++i) ASSERT_TRUE(world.step());
}

bool sleeps(const World& world, const std::string& name) {
  return world.physics_data()->body_awake[world.body(name)] == mjS_ASLEEP;
}

Vector3d place_of(const World& world, const std::string& name) {
  return world.body_pose(world.body(name)).translation();
}

TEST(Rest, WhatLiesStillSleepsWhereItWouldLieAwake) {
  World resting = make(stack()), other = make(awake(stack()));
  cycles(resting, 1000);
  cycles(other, 1000);
  for (const char* name : {"lower", "upper", "beside"}) {
    EXPECT_TRUE(sleeps(resting, name)) << name;
    EXPECT_FALSE(sleeps(other, name)) << name;
    EXPECT_LT((place_of(resting, name) - place_of(other, name)).norm(), 1e-8) << name;
  }
  EXPECT_EQ(resting.physics_data()->ncon, 0);
  EXPECT_GT(other.physics_data()->ncon, 0);
}

TEST(Rest, AForceThatIsWatchedStaysWhileItSleeps) {
  World world = make(stack());
  const std::size_t below = *world.watch_contact("plate", "lower"), between = *world.watch_contact("lower", "upper");
  cycles(world, 1000);
  ASSERT_TRUE(sleeps(world, "upper"));
  EXPECT_NEAR(world.contact(below).force_W.z(), 0.8 * kEarthPull, 1e-3);
  EXPECT_NEAR(world.contact(between).force_W.z(), 0.3 * kEarthPull, 1e-3);
  EXPECT_EQ(world.contact(between).contacts, 4);
  // Awake, the reading is that of the contacts again, once and not twice.
  world.push(world.body("upper"), {0.0, 0.0, -1.0});
  cycles(world, 300);
  EXPECT_NEAR(world.contact(below).force_W.z(), 0.8 * kEarthPull + 1.0, 1e-3);
  EXPECT_EQ(world.contact(between).contacts, 4);
}

TEST(Rest, AForceWakesAllThatTouches) {
  World world = make(stack());
  cycles(world, 1000);
  world.push(world.body("lower"), {0.1, 0.0, 0.0});
  cycles(world, 2);
  EXPECT_FALSE(sleeps(world, "lower"));
  EXPECT_FALSE(sleeps(world, "upper"));
  EXPECT_TRUE(sleeps(world, "beside"));
}

TEST(Rest, APartThatIsHitMovesAsIfItHadBeenAwake) {
  const auto shoot = [](World& world) {
    cycles(world, 1000);
    // It is woken first, as a push of what sleeps is felt one step later.
    world.push(world.body("beside"), {1e-6, 0.0, 0.0});
    cycles(world, 2);
    world.push(world.body("beside"), {-40.0, 0.0, 0.0});
    cycles(world, 50);
    world.push(world.body("beside"), {0.0, 0.0, 0.0});
    cycles(world, 50);
  };
  World resting = make(stack()), other = make(awake(stack()));
  shoot(resting);
  shoot(other);
  EXPECT_GT(place_of(other, "lower").norm(), 0.05);  // it was hit
  for (const char* name : {"lower", "upper", "beside"})
    EXPECT_LT((place_of(resting, name) - place_of(other, name)).norm(), 1e-5) << name;
}

TEST(Rest, ASlopeHoldsWhatSleepsByTheFrictionThatItHadAwake) {
  WorldDescription description = stack();
  description.physics.gravity = Vector3d(2.5, 0.0, -9.4);  // 15 degrees
  World resting = make(description), other = make(awake(description));
  cycles(resting, 2000);
  cycles(other, 2000);
  ASSERT_TRUE(sleeps(resting, "upper"));
  const Vector3d before = place_of(resting, "lower");
  resting.push(resting.body("upper"), {0.0, 0.0, 1e-6});  // wakes, and no more
  cycles(resting, 1000);
  EXPECT_FALSE(sleeps(resting, "upper"));
  EXPECT_LT((place_of(resting, "lower") - before).norm(), 1e-8);
  EXPECT_LT((place_of(resting, "lower") - place_of(other, "lower")).norm(), 1e-8);
}

TEST(Rest, WhatAnArmTouchesStaysAwake) {
  WorldDescription description;
  description.robots.push_back(lwr());
  add_probe(description);
  description.arms.push_back(lwr_controller());
  const World empty = make(description);
  const Vector3d ball = empty.body_pose(empty.body("probe/tcp")).translation();
  description.objects.push_back(box("plate", {0.5, 0.5, 0.1}, ball - Vector3d(0, 0, 0.005 + 0.05 + 0.05 - 5e-5)));
  // The first cube is 0.05 mm higher than there is room for below the ball; the second one lies beside it.
  const double middle = 0.005 + 0.025 - 5e-5;
  description.objects.push_back(loose("under", {0.05, 0.05, 0.05}, ball - Vector3d(0, 0, middle), 0.2));
  description.objects.push_back(loose("beside", {0.05, 0.05, 0.05}, ball - Vector3d(0.1, 0, middle), 0.2));
  World world = make(description);
  hold(world, lwr_home(), 1500);
  EXPECT_FALSE(sleeps(world, "under"));
  EXPECT_TRUE(sleeps(world, "beside"));
}

TEST(Rest, ASnapshotOfSleepContinuesBitForBit) {
  World world = make(stack());
  ASSERT_TRUE(world.watch_contact("lower", "upper"));
  cycles(world, 1000);
  ASSERT_TRUE(sleeps(world, "upper"));
  const Snapshot snapshot = world.save();
  const auto go_on = [](World& from) {
    std::vector<Snapshot> seen;
    cycles(from, 20);
    from.push(from.body("beside"), {-40.0, 0.0, 0.0});
    for (int i = 0; i < 400; ++i) {
      cycles(from, 1);
      if (i == 50) from.push(from.body("beside"), {0.0, 0.0, 0.0});
      seen.push_back(from.save());
    }
    return seen;
  };
  const std::vector<Snapshot> first = go_on(world);
  World fresh = make(stack());
  ASSERT_TRUE(fresh.watch_contact("lower", "upper"));
  for (World* target : {&world, &fresh}) {
    ASSERT_TRUE(target->restore(snapshot));
    EXPECT_EQ(target->save(), snapshot);
    EXPECT_EQ(go_on(*target), first);
  }
}

/// A mobile base with a crate on its deck, which begins a tenth of a millimetre above it.
WorldDescription loaded_base() {
  const auto base = device::read_base("models/youbot_base");
  EXPECT_TRUE(base);
  WorldDescription world;
  world.robots.push_back(arm_body("base", **base, {}));
  world.arms.push_back(simulated_base("base", "base", **base));
  world.objects.push_back(loose("crate", {0.2, 0.2, 0.06}, {-0.15, 0.0, 0.1275 + 0.03 + 1e-4}, 2.0));
  return world;
}

/// Tells the base to be `x` m ahead, at a speed in m/s, for that many cycles.
void command(World& world, double x, double speed, int count) {
  device::ArmSetPoint set_point;
  set_point.q = set_point.dq = set_point.ddq = JointVector::Zero(3);
  for (int i = 0; i < count; ++i) {
    x += speed * 0.001;
    set_point.q[0] = x;
    set_point.dq[0] = speed;
    world.arm("base")->write(set_point);
    ASSERT_TRUE(world.step());
  }
}

TEST(Rest, ABaseThatStandsSleepsWithWhatItCarries) {
  World resting = make(loaded_base()), other = make(awake(loaded_base()));
  for (World* world : {&resting, &other}) {
    command(*world, 0.0, 0.0, 1500);
    EXPECT_EQ(sleeps(*world, "base/body"), world == &resting);
    EXPECT_EQ(sleeps(*world, "crate"), world == &resting);
    command(*world, 0.0, 0.05, 2);
    EXPECT_FALSE(sleeps(*world, "base/body"));
    EXPECT_FALSE(sleeps(*world, "crate"));
    command(*world, 1e-4, 0.05, 1998);
    EXPECT_FALSE(sleeps(*world, "crate"));
    command(*world, 0.1, 0.0, 2000);
    EXPECT_NEAR(place_of(*world, "crate").x(), 0.1 - 0.15, 5e-4);
  }
  for (const char* name : {"base/body", "crate"})
    EXPECT_LT((place_of(resting, name) - place_of(other, name)).norm(), 1e-4) << name;
}

TEST(Rest, AParkedBaseStaysPutAndWakesWhereItIsPushed) {
  World world = make(loaded_base());
  command(world, 0.0, 0.0, 1500);
  ASSERT_TRUE(sleeps(world, "base/body"));
  const Snapshot snapshot = world.save();
  const auto push = [](World& from) {
    from.push(from.body("crate"), {30.0, 0.0, 0.0});
    command(from, 0.0, 0.0, 100);
    EXPECT_FALSE(sleeps(from, "base/body"));
    return from.save();
  };
  const Snapshot pushed = push(world);
  World fresh = make(loaded_base());
  ASSERT_TRUE(fresh.restore(snapshot));
  EXPECT_EQ(push(fresh), pushed);
}

TEST(Rest, AListedContactOfAMachineThatStandsStaysListed) {
  WorldDescription description = stack();
  RobotDescription table;
  table.name = "table";
  table.model = model("table");
  table.mount.X_P.translation() = Vector3d(0.0, 2.0, 0.0);
  description.robots.push_back(table);
  description.objects.push_back(loose("on table", {0.04, 0.04, 0.04}, {0.0, 2.0, 0.7701}, 0.5));
  World world = make(description);
  std::vector<bool> machines;
  for (const std::string& body : world.body_names()) machines.push_back(body.starts_with("table/"));
  world.list_contacts_of(machines);
  cycles(world, 1000);
  ASSERT_TRUE(sleeps(world, "on table"));
  const Snapshot snapshot = world.save();
  for (int i = 0; i < 2; ++i) {
    (void)world.take_contacts();
    cycles(world, 1);
    const auto contacts = world.take_contacts();
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_NEAR(contacts[0].force, 0.5 * kEarthPull, 1e-3);
    EXPECT_LT((contacts[0].point_W.head<2>() - Eigen::Vector2d(0.0, 2.0)).norm(), 1e-3);
    ASSERT_TRUE(world.restore(snapshot));
  }
  world.push(world.body("on table"), {0.0, 0.0, 20.0});
  cycles(world, 200);
  (void)world.take_contacts();
  cycles(world, 1);
  EXPECT_TRUE(world.take_contacts().empty());
}

TEST(Rest, FallingAsleepAndWakingAllocateNothing) {
  World world = make(stack());
  ASSERT_TRUE(world.watch_contact("lower", "upper"));
  cycles(world, 10);
  const takt::test::AllocationGuard guard;
  bool stepped = true;
  for (int i = 0; i < 2000; ++i) {
    if (i == 1000) world.push(world.body("lower"), {5.0, 0.0, 0.0});
    if (i == 1050) world.push(world.body("lower"), {0.0, 0.0, 0.0});
    stepped = world.step() && stepped;
  }
  EXPECT_TRUE(stepped);
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace takt::sim::test
