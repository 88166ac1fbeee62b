// A belt that takes along what lies on it. Figures: models/belt_1m.
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "core/device/conveyor.h"
#include "sim/machines/conveyor.h"
#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kTop = 0.64;          // m, of the belt
constexpr double kAcceleration = 0.5;  // m/s^2

const device::ConveyorDescription& figures() {
  static const auto conveyor = device::read_conveyor("models/belt_1m");
  if (!conveyor) ADD_FAILURE() << conveyor.error().to_string();
  return **conveyor;
}

/// A cube of 1 kg lies on a belt, 0.1 m from where that begins.
class CubeOnBelt : public testing::Test {
 protected:
  void build(double friction, double noise = 0.0) {
    WorldDescription description;
    RobotDescription belt;
    belt.name = "belt";
    belt.model = model("belt_1m");
    belt.contact.friction = friction;
    belt.contact.own_friction = true;
    description.robots.push_back(belt);
    device::ConveyorDescription conveyor = figures();
    conveyor.noise = noise;
    description.devices.push_back({.name = "belt",
                                   .pointer = {},
                                   .extend = {},
                                   .make = [conveyor](const mjModel_& plant, const WorldDescription& whole) {
                                     return SimConveyor::make(plant, "belt", conveyor, whole.seed);
                                   }});
    ObjectDescription cube = box("cube", {0.05, 0.05, 0.05}, {0.1, 0.0, kTop + 0.025});
    cube.free = true;
    cube.mass = 1.0;
    cube.contact.friction = friction;
    cube.contact.own_friction = true;
    description.objects.push_back(cube);
    world_.emplace(make(description));
    cube_ = world_->body("cube");
  }
  SimConveyor& belt() { return dynamic_cast<SimConveyor&>(*world_->device("belt")); }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(1e3 * seconds); ++i) ASSERT_TRUE(world_->step());
  }
  void set(double speed) {
    belt().run.write(speed != 0.0);
    if (speed != 0.0) belt().speed.write(speed);
  }
  [[nodiscard]] double x() const { return world_->body_pose(cube_).translation().x(); }
  [[nodiscard]] double counted() {
    device::SignalSample<double> sample;
    EXPECT_TRUE(belt().position.read(sample));
    return sample.value;
  }

  std::optional<World> world_;
  int cube_ = 0;
};

TEST_F(CubeOnBelt, GoesWithIt) {
  build(0.6);
  run(0.3);
  const double begin = x();
  set(0.2);
  run(2.0);
  // It ramps up to its speed in 0.4 s.
  const double way = 0.2 * 2.0 - 0.5 * 0.2 * 0.2 / kAcceleration;
  EXPECT_NEAR(counted(), way, 5e-4);
  EXPECT_NEAR(x() - begin, way, 5e-4);
  EXPECT_NEAR(world_->body_pose(cube_).translation().y(), 0.0, 1e-5) << "and nowhere else";
  set(0.0);
  run(1.0);
  const double end = way + 0.5 * 0.2 * 0.2 / kAcceleration;
  EXPECT_NEAR(counted(), end, 5e-4);
  EXPECT_NEAR(x() - begin, end, 5e-4);
  const double rest = x();
  run(1.0);
  EXPECT_NEAR(x(), rest, 1e-6);
}

TEST_F(CubeOnBelt, WakesWhenTheBeltStarts) {
  build(0.6);
  run(3.0);
  const double begin = x();
  set(-0.05);
  run(1.0);
  EXPECT_NEAR(x() - begin, -0.05 + 0.5 * 0.05 * 0.05 / kAcceleration, 5e-4);
}

/// It gets no faster than its friction makes it: mu g.
TEST_F(CubeOnBelt, SlipsWhereTheBeltIsFasterThanFriction) {
  constexpr double kFriction = 0.02;
  build(kFriction);
  run(0.3);
  const double begin = x();
  set(0.5);
  run(1.0);
  EXPECT_NEAR(x() - begin, 0.5 * kFriction * 9.81, 0.02 * 0.5 * kFriction * 9.81);
}

TEST_F(CubeOnBelt, TheEncoderCountsSteps) {
  build(0.6, /*noise=*/5e-5);
  set(0.1);
  bool noisy = false;
  for (int i = 0; i < 1000; ++i) {
    const double before = world_->time() > 0 ? counted() : 0.0;
    ASSERT_TRUE(world_->step());
    const double steps = counted() / figures().resolution;
    ASSERT_NEAR(steps, std::round(steps), 1e-6);
    noisy = noisy || counted() < before;
  }
  EXPECT_TRUE(noisy) << "single samples go back";
  EXPECT_NEAR(counted(), 0.1 - 0.5 * 0.1 * 0.1 / kAcceleration, 6.0 * 5e-5 + figures().resolution);
}

TEST_F(CubeOnBelt, AStateGoesOnBitForBit) {
  build(0.6, /*noise=*/5e-5);
  set(0.2);
  run(0.2);
  const Snapshot snapshot = world_->save();
  run(0.5);
  const double first = x(), count = counted();
  ASSERT_TRUE(world_->restore(snapshot));
  run(0.5);
  EXPECT_EQ(x(), first);
  EXPECT_EQ(counted(), count);
}

}  // namespace
}  // namespace takt::sim::test
