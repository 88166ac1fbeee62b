// Suction cups under a plate: what they pull, together and with somebody who pushes. Figures of the cup:
// models/vacuum_cup30.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <optional>
#include <string>
#include <utility>

#include "core/device/vacuum_cup.h"
#include "sim/contact/contact_law.h"
#include "sim/machines/vacuum_cup.h"
#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kPull = 80'000 * 5.3e-4;  // N, of one cup

/// A plate of 1 kg lies on the mouths of two cups that stand on the floor.
class PlateOnCups : public testing::Test {
 protected:
  PlateOnCups() {
    WorldDescription description;
    for (const auto& [name, x] : {std::pair("left", -0.06), std::pair("right", 0.06)}) {
      RobotDescription cup;
      cup.name = name;
      cup.model = model("vacuum_cup30");
      cup.mount.X_P.translation() = Vector3d(x, 0.0, 0.0);
      cup.joints.push_back({.joint = "plunge", .spring = JointSpring{.stiffness = 1e4, .damping = 20, .preload = 0.5}});
      for (const char* lean : {"lean_x", "lean_y"})
        cup.joints.push_back({.joint = lean, .spring = JointSpring{.stiffness = 0.85, .damping = 0.0017}});
      description.robots.push_back(cup);
      description.devices.push_back(
          {.name = name,
           .pointer = {},
           .extend = {},
           .make = [name = std::string(name)](const mjModel_& model, const WorldDescription&) {
             const auto figures = device::read_vacuum_cup("models/vacuum_cup30");
             return SimVacuumCup::make(model, name, **figures);
           }});
    }
    ObjectDescription plate = box("plate", {0.2, 0.06, 0.01}, {0.0, 0.0, 0.082 + 0.005});
    plate.free = true;
    plate.mass = 1.0;
    description.objects.push_back(plate);
    world_.emplace(make(description));
    plate_ = world_->body("plate");
    run(0.2);
  }

  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(1e3 * seconds); ++i) ASSERT_TRUE(world_->step());
  }
  void suck(const char* cup, bool on) { dynamic_cast<SimVacuumCup&>(*world_->device(cup)).suction.write(on); }
  /// On the plate, in the newest step.
  [[nodiscard]] double applied() const { return world_->physics_data()->xfrc_applied[6 * plate_ + 2]; }
  [[nodiscard]] double height() const { return world_->body_pose(plate_).translation().z(); }

  std::optional<World> world_;
  int plate_ = 0;
};

TEST_F(PlateOnCups, EachPullsWithItsPressureTimesItsArea) {
  suck("left", true);
  suck("right", true);
  run(0.5);
  const double held = height();
  EXPECT_NEAR(applied(), -2.0 * kPull, 0.01 * kPull);
  const double pull = applied();
  run(2.0);
  EXPECT_NEAR(applied(), pull, 0.01) << "and no more with time";
  EXPECT_NEAR(height(), held, 1e-5);
  EXPECT_EQ(world_->contact_law().forgotten(), 0) << "friction is remembered at every point of both lips";
  suck("left", false);
  run(0.5);
  EXPECT_NEAR(applied(), -kPull, 0.01 * kPull);
  suck("right", false);
  run(0.5);
  EXPECT_NEAR(applied(), 0.0, 0.01 * kPull);
}

TEST_F(PlateOnCups, WhoPushesThePlateIsHeardBesideThem) {
  suck("left", true);
  suck("right", true);
  run(0.5);
  const double pull = applied();
  world_->push(plate_, {0.0, 0.0, 5.0});
  run(0.5);
  EXPECT_NEAR(applied(), pull + 5.0, 0.1);
  world_->push(plate_, Vector3d::Zero());
  run(0.5);
  EXPECT_NEAR(applied(), pull, 0.1);
}

TEST_F(PlateOnCups, AStateGoesOnBitForBit) {
  suck("left", true);
  suck("right", true);
  run(0.05);
  const Snapshot snapshot = world_->save();
  run(0.3);
  const double first = height(), force = applied();
  ASSERT_TRUE(world_->restore(snapshot));
  run(0.3);
  EXPECT_EQ(height(), first);
  EXPECT_EQ(applied(), force);
}

}  // namespace
}  // namespace takt::sim::test
