// Suction: the force of the air on the mouth, less what a tilting load takes. Figures of the cup: models/vacuum_cup30.
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "core/device/vacuum_cup.h"
#include "sim/machines/vacuum_cup.h"
#include "tests/physics/parts.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kAir = 80'000 * 5.3e-4;  // N
constexpr double kLip = 0.013;            // m, radius of the circle of its points
constexpr double kPlate = 0.2;            // kg

/// A cup that stands on the floor, leaning, with a plate of 0.2 kg on its mouth.
WorldDescription plate_on_cup(double lean) {
  WorldDescription description;
  RobotDescription cup;
  cup.name = "cup";
  auto model = kinematics::RobotModel::load("models/vacuum_cup30/vacuum_cup30.urdf");
  EXPECT_TRUE(model.has_value());
  cup.model = std::make_shared<kinematics::RobotModel>(std::move(*model));
  cup.mount.X_P = Pose(Eigen::AngleAxisd(lean, Vector3d::UnitY()));
  cup.contact = ContactParameters{.material = "rubber", .stiffness = 5.2e5, .damping = 830.0, .friction = 0.8};
  cup.joints.push_back({.joint = "plunge", .spring = JointSpring{.stiffness = 1e4, .damping = 20, .preload = 0.5}});
  for (const char* joint : {"lean_x", "lean_y"})
    cup.joints.push_back({.joint = joint, .spring = JointSpring{.stiffness = 0.85, .damping = 0.0017}});
  description.robots.push_back(cup);
  description.devices.push_back(
      {.name = "cup", .pointer = {}, .extend = {}, .make = [](const mjModel_& made, const WorldDescription&) {
         const auto figures = device::read_vacuum_cup("models/vacuum_cup30");
         return SimVacuumCup::make(made, "cup", **figures);
       }});
  description.objects.push_back(part("plate", kinematics::Box{{0.1, 0.1, 0.01}}, kPlate, {0.0, 0.0, 0.0}));
  return description;
}

/// The pull along z, N, at which a plate comes off, if it acts at `lever` beside the middle.
double pull_that_parts(double lever) {
  WorldDescription description = plate_on_cup(0.0);
  description.objects.front().mount.X_P.translation().z() = 0.082 + 0.005;
  World world = built(description);
  const int plate = world.body("plate");
  auto& cup = dynamic_cast<SimVacuumCup&>(*world.device("cup"));
  cup.suction.write(true);
  run_for(world, 0.5);
  const double height = place_of(world, "plate").z();
  for (double pull = 0.0; pull < 2.0 * kAir; pull += 0.02) {
    world.push(plate, {0.0, 0.0, pull}, {0.0, -pull * lever, 0.0});
    if (!world.step()) break;
    if (place_of(world, "plate").z() > height + 0.012) return pull;
  }
  return 1e9;
}

TEST(Suction, HoldsTheForceOfTheAirLessTheShareOfTheMoment) {
  // The edge of a ring that bears evenly is free when the moment is half of force times radius.
  for (const double lever : {0.0, 0.002, 0.005}) {
    const double expected = (kAir + kPlate * kGravity) / (1.0 + 2.0 * lever / kLip);
    EXPECT_NEAR(pull_that_parts(lever), expected, 0.1 * expected) << lever;
  }
}

TEST(Suction, ALeaningCupGetsTightAndHolds) {
  for (const double degrees : {0.2, 1.0, 3.0}) {
    const double lean = degrees * M_PI / 180.0;
    WorldDescription description = plate_on_cup(lean);
    // A level plate that is fixed; the cup stands under it and is pressed by 6 N.
    const Vector3d mouth(0.082 * std::sin(lean), 0.0, 0.082 * std::cos(lean));
    ObjectDescription& plate = description.objects.front();
    plate.free = false;
    plate.mount.X_P.translation() = mouth + Vector3d(0.0, 0.0, 0.005 - 0.0006);
    World world = built(description);
    auto& cup = dynamic_cast<SimVacuumCup&>(*world.device("cup"));
    cup.suction.write(true);
    run_for(world, 0.5);
    EXPECT_GT(*cup.holding.wire(), 0.5) << degrees;
  }
}

}  // namespace
}  // namespace takt::sim::test
