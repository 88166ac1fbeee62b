#include <cmath>

#include <gtest/gtest.h>

#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

constexpr double kGravity = 9.81;

/// A sensor hanging in the world, tool side up or down, with a block of `mass` on its tool side.
WorldDescription bench(double mass, const Eigen::Quaterniond& orientation) {
  WorldDescription world;
  RobotDescription sensor;
  sensor.name = "sensor";
  sensor.model = model("ft_gamma");
  sensor.mount.X_P = Pose(orientation);
  sensor.mount.X_P.translation().z() = 1.0;
  world.robots.push_back(sensor);
  if (mass > 0.0) {
    ObjectDescription load = box("load", {0.1, 0.1, 0.1}, {0.02, 0, 0.05});
    load.mass = mass;
    load.mount.parent = "sensor/tool";
    world.objects.push_back(load);
  }
  SimForceTorqueDescription wrist;
  wrist.name = "wrist";
  wrist.tool_side = "sensor/measuring";
  world.force_torque_sensors.push_back(wrist);
  return world;
}

Eigen::Quaterniond about_x(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()));
}

double plate_mass() { return model("ft_gamma")->link("measuring")->inertial->mass; }

void run(World& world, int cycles) {
  for (int i = 0; i < cycles; ++i) ASSERT_TRUE(world.step());
}

TEST(SimForceTorque, LevelLoadPullsDown) {
  // What gravity exerts on the tool side: with z up it reads minus the weight, and the plate belongs to the tool side.
  World world = make(bench(2.0, Eigen::Quaterniond::Identity()));
  run(world, 10);
  const auto reading = wrench(world).wrench;
  const double weight = (2.0 + plate_mass()) * kGravity;
  EXPECT_LT((reading.force - Eigen::Vector3d(0, 0, -weight)).norm(), 1e-9);
  // The load's centre lies 20 mm towards +x: its weight turns about +y.
  EXPECT_LT((reading.torque - Eigen::Vector3d(0, 0.02 * 2.0 * kGravity, 0)).norm(), 1e-9);
}

TEST(SimForceTorque, HangingLoadPullsAlongItsOwnAxis) {
  World world = make(bench(2.0, about_x(EIGEN_PI)));
  run(world, 10);
  const double weight = (2.0 + plate_mass()) * kGravity;
  EXPECT_LT((wrench(world).wrench.force - Eigen::Vector3d(0, 0, weight)).norm(), 1e-9);
}

TEST(SimForceTorque, ReadsInItsMeasuringFrame) {
  WorldDescription description = bench(2.0, Eigen::Quaterniond::Identity());
  Pose& X_LS = description.force_torque_sensors[0].X_LS;
  X_LS = Pose(about_x(EIGEN_PI / 2));
  X_LS.translation() << -0.1, 0, 0;
  World world = make(description);
  run(world, 10);
  const auto reading = wrench(world).wrench;
  const double weight = (2.0 + plate_mass()) * kGravity;
  // Down in the world is -y in S; about S the load has a longer lever.
  EXPECT_LT((reading.force - Eigen::Vector3d(0, -weight, 0)).norm(), 1e-9);
  const double turning = kGravity * (2.0 * 0.12 + plate_mass() * 0.1);
  EXPECT_LT((reading.torque - Eigen::Vector3d(0, 0, -turning)).norm(), 1e-9);
}

TEST(SimForceTorque, SurroundingsThatPushUpReadUp) {
  // The load rests on a table that carries part of it: the table's push counts as plus.
  WorldDescription description;
  description.robots.push_back(lwr());
  description.arms.push_back(lwr_controller());
  add_probe(description);
  const World empty = make(description);
  Eigen::Vector3d under = empty.body_pose(empty.body("probe/tcp")).translation();
  under.z() -= 0.005 + 0.05 - 0.0005;  // half a millimetre into the ball: it must give way
  description.objects.push_back(box("table", {0.3, 0.3, 0.1}, under));
  World world = make(description);
  const std::size_t watch = *world.watch_contact("probe", "table");
  World free = make([&] {
    WorldDescription without = description;
    without.objects.clear();
    return without;
  }());
  hold(world, lwr_home(), 500);
  hold(free, lwr_home(), 500);
  const Eigen::Vector3d push = wrench(world).wrench.force - wrench(free).wrench.force;
  // The probe points down, so up in the world is -z of the sensor; friction adds to it sideways.
  EXPECT_GT(world.contact(watch).force, 1.0);
  EXPECT_NEAR(push.norm(), world.contact(watch).force, 0.01 * world.contact(watch).force);
  EXPECT_LT(push.z(), -0.9 * push.norm());
}

TEST(SimForceTorque, AtRestOnTheArmReadsToolWeight) {
  WorldDescription description;
  description.robots.push_back(lwr());
  description.arms.push_back(lwr_controller());
  add_probe(description);
  auto& wrist = description.force_torque_sensors[0];
  wrist.force_noise << 0.025, 0.025, 0.05;
  wrist.torque_noise.setConstant(0.00125);
  World world = make(description);
  hold(world, lwr_home(), 100);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const int n = 1000;
  for (int k = 0; k < n; ++k) {
    hold(world, lwr_home(), 1);
    mean += wrench(world).wrench.force / n;
  }
  const double weight = (plate_mass() + model("probe_ball")->total_mass()) * kGravity;
  EXPECT_LT((mean - Eigen::Vector3d(0, 0, weight)).norm(), 0.1);
}

TEST(SimForceTorque, NoiseHasItsSigmaAndItsSeed) {
  WorldDescription description = bench(1.0, Eigen::Quaterniond::Identity());
  description.force_torque_sensors[0].force_noise << 0.5, 0, 0;
  const auto readings = [&](std::uint64_t seed) {
    description.seed = seed;
    World world = make(description);
    std::vector<double> values;
    for (int k = 0; k < 4000; ++k) {
      EXPECT_TRUE(world.step());
      values.push_back(wrench(world).wrench.force.x());
      EXPECT_NEAR(wrench(world).wrench.force.y(), 0.0, 1e-9);
    }
    return values;
  };
  const auto values = readings(1);
  double squares = 0.0;
  for (const double v : values) squares += v * v;
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(values.size())), 0.5, 0.03);
  EXPECT_EQ(values, readings(1));
  EXPECT_NE(values, readings(2));
}

TEST(SimForceTorque, BiasIsDrawnOnceFromTheSeed) {
  WorldDescription description = bench(0.0, Eigen::Quaterniond::Identity());
  description.force_torque_sensors[0].force_bias << 1, 1, 2;
  const auto bias = [&](std::uint64_t seed) {
    description.seed = seed;
    World world = make(description);
    run(world, 5);
    const Eigen::Vector3d early = wrench(world).wrench.force;
    run(world, 100);
    EXPECT_EQ(early, wrench(world).wrench.force);
    return Eigen::Vector3d(early + Eigen::Vector3d(0, 0, plate_mass() * kGravity));
  };
  EXPECT_GT(bias(1).norm(), 0.01);
  EXPECT_NE(bias(1), bias(2));
}

TEST(SimForceTorque, ClipsAtItsRangeAndSaysSo) {
  WorldDescription description = bench(2.0, Eigen::Quaterniond::Identity());
  description.force_torque_sensors[0].force_range << 10, 10, 10;
  World world = make(description);
  run(world, 2);
  EXPECT_TRUE(wrench(world).overload);
  EXPECT_EQ(wrench(world).wrench.force.z(), -10.0);
  World light = make(bench(0.0, Eigen::Quaterniond::Identity()));
  run(light, 2);
  EXPECT_FALSE(wrench(light).overload);
}

TEST(SimForceTorque, SamplesAtItsOwnPeriodOneStepOld) {
  WorldDescription description = bench(1.0, Eigen::Quaterniond::Identity());
  description.force_torque_sensors[0].period = 4 * kMillisecond;
  World world = make(description);
  const auto first = wrench(world).sequence;
  run(world, 3);
  EXPECT_EQ(wrench(world).sequence, first);
  run(world, 1);
  EXPECT_EQ(wrench(world).sequence, first + 1);
  EXPECT_EQ(wrench(world).stamp, 3 * kMillisecond);
}

TEST(SimForceTorque, LowPassFollowsAStepWithItsTimeConstant) {
  // A free fall that a stop ends is no clean step; a filter on the reading of a load that swings in is: compare the
  // filtered arm motion with the raw one filtered here.
  WorldDescription description;
  description.robots.push_back(lwr());
  description.arms.push_back(lwr_controller());
  add_probe(description);
  WorldDescription filtered = description;
  filtered.force_torque_sensors[0].low_pass_Hz = 20.0;
  World raw_world = make(description);
  World filtered_world = make(filtered);
  const double gain = 1.0 - std::exp(-2.0 * EIGEN_PI * 20.0 * 1e-3);
  Eigen::Vector3d expected = wrench(raw_world).wrench.force;
  JointVector goal = lwr_home();
  goal[1] += 0.02;
  for (int k = 0; k < 100; ++k) {
    hold(raw_world, goal, 1);
    hold(filtered_world, goal, 1);
    expected += gain * (wrench(raw_world).wrench.force - expected);
    ASSERT_LT((wrench(filtered_world).wrench.force - expected).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace takt::sim::test
