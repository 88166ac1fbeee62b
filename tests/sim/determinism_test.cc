// Rows D4, D5: equal runs are equal bits, a snapshot continues bit for bit, and the digest's bytes miss nothing.
#include <cmath>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

WorldDescription noisy_cell() {
  WorldDescription world;
  world.robots.push_back(lwr());
  add_probe(world);
  world.arms.push_back(lwr_controller());
  world.arms[0].control.friction_observer = JointVector::Constant(7, 60.0);
  world.arms[0].measurement.torque_noise = JointVector::Constant(7, 0.1);
  world.arms[0].measurement.velocity_noise = 1e-4;
  world.force_torque_sensors[0].force_noise.setConstant(0.05);
  // The ball rests half a millimetre in a block, so that contacts and the solver's warm start take part.
  const World empty = make(world);
  Eigen::Vector3d under = empty.body_pose(empty.body("probe/tcp")).translation();
  under.z() -= 0.005 + 0.05 - 0.0005;
  world.objects.push_back(box("block", {0.3, 0.3, 0.1}, under));
  ObjectDescription loose = box("loose", {0.04, 0.04, 0.04}, under + Eigen::Vector3d(0.1, 0, 0.08));
  loose.free = true;
  loose.mass = 0.3;
  world.objects.push_back(loose);
  return world;
}

void drive(World& world, int k) {
  JointVector q = lwr_home();
  q[0] += 0.002 * std::sin(0.01 * k);
  world.arm("arm")->write(set_point(q));
  ASSERT_TRUE(world.step());
}

std::vector<std::byte> bytes(const World& world) {
  const auto state = world.state_bytes();
  return {state.begin(), state.end()};
}

TEST(Determinism, D5_TwoRunsGiveTheSameBits) {
  World a = make(noisy_cell());
  World b = make(noisy_cell());
  for (int k = 0; k < 500; ++k) {
    drive(a, k);
    drive(b, k);
    ASSERT_EQ(bytes(a), bytes(b)) << "cycle " << k;
  }
}

TEST(Determinism, D4_StateChangesWhereverTheRunDiffers) {
  World a = make(noisy_cell());
  World b = make(noisy_cell());
  // The lowest bit of one set point must show in the same cycle.
  JointVector q = lwr_home();
  a.arm("arm")->write(set_point(q));
  q[3] = std::nextafter(q[3], 10.0);
  b.arm("arm")->write(set_point(q));
  ASSERT_TRUE(a.step());
  ASSERT_TRUE(b.step());
  EXPECT_NE(bytes(a), bytes(b));
}

TEST(Determinism, SnapshotContinuesBitForBit) {
  World world = make(noisy_cell());
  ASSERT_TRUE(world.watch_contact("probe", "block"));
  for (int k = 0; k < 200; ++k) drive(world, k);
  const Snapshot snapshot = world.save();
  std::vector<std::vector<std::byte>> first;
  for (int k = 200; k < 400; ++k) {
    drive(world, k);
    first.push_back(bytes(world));
  }
  const double max_force = world.contact(0).max_force;
  const auto at_end = wrench(world).wrench.force;

  // Into the same world, and into a fresh one.
  World fresh = make(noisy_cell());
  ASSERT_TRUE(fresh.watch_contact("probe", "block"));
  for (World* target : {&world, &fresh}) {
    ASSERT_TRUE(target->restore(snapshot));
    EXPECT_EQ(target->time(), 200 * kMillisecond);
    for (int k = 200; k < 400; ++k) {
      drive(*target, k);
      ASSERT_EQ(bytes(*target), first[static_cast<std::size_t>(k - 200)]) << "cycle " << k;
    }
    EXPECT_EQ(target->contact(0).max_force, max_force);
    EXPECT_EQ(wrench(*target).wrench.force, at_end);
  }
}

TEST(Determinism, SnapshotKeepsBrakesFaultsAndPayload) {
  World world = make(noisy_cell());
  for (int k = 0; k < 50; ++k) drive(world, k);
  world.arm("arm")->set_payload({.mass = 3.0});
  JointVector far = lwr_home();
  far[0] += 1.0;
  world.arm("arm")->write(set_point(far));
  ASSERT_TRUE(world.step());
  const Snapshot snapshot = world.save();
  World fresh = make(noisy_cell());
  ASSERT_TRUE(fresh.restore(snapshot));
  EXPECT_FALSE(sample(fresh).ready);
  EXPECT_EQ(sample(fresh).fault, sample(world).fault);
  EXPECT_EQ(fresh.arm("arm")->payload().mass, 3.0);
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(world.step());
    ASSERT_TRUE(fresh.step());
    ASSERT_EQ(bytes(world), bytes(fresh));
  }
}

TEST(Determinism, SnapshotOfAnotherWorldIsRefused) {
  World world = make(noisy_cell());
  const auto before = bytes(world);
  Snapshot snapshot = world.save();
  snapshot.push_back(0);
  EXPECT_FALSE(world.restore(snapshot));
  EXPECT_EQ(bytes(world), before);
}

}  // namespace
}  // namespace takt::sim::test
