// Friction of pairs: rules, oil, and rolling resistance as textbooks have it.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/contact/contact_law.h"
#include "tests/physics/parts.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

TEST(Friction, APairsOwnFigureWinsOverTheLargerOne) {
  const ContactParameters rubber{.material = "rubber", .friction = 0.8}, ptfe{.material = "ptfe", .friction = 0.05};
  const std::vector<ContactRule> rules{{.between = {"rubber", "ptfe"}, .friction = 0.3}};
  EXPECT_EQ(combine(rubber, ptfe, {}).friction, 0.8);
  EXPECT_EQ(combine(rubber, ptfe, rules).friction, 0.3);
  ContactParameters pad = rubber;
  pad.friction = 0.7;
  pad.own_friction = pad.by_rules = true;
  EXPECT_EQ(combine(pad, ptfe, rules).friction, 0.3);
  EXPECT_EQ(combine(pad, ptfe, {}).friction, 0.7);
  ContactParameters chosen = ptfe;
  chosen.friction = 0.2;
  chosen.own_friction = true;
  EXPECT_EQ(combine(rubber, chosen, rules).friction, 0.8) << "what an object says of itself, no rule replaces";
}

TEST(Friction, OilIsAStateOfASurface) {
  ContactParameters steel{.material = "steel", .friction = 0.6, .oiled_friction = 0.12};
  ContactParameters brass{.material = "brass", .friction = 0.5, .oiled_friction = 0.1};
  EXPECT_EQ(combine(steel, brass, {}).friction, 0.6);
  brass.oiled = true;
  EXPECT_EQ(combine(steel, brass, {}).friction, 0.12);
  const std::vector<ContactRule> rules{{.between = {"steel", "brass"}, .friction = 0.5, .oiled_friction = 0.08}};
  EXPECT_EQ(combine(steel, brass, rules).friction, 0.08);
  ContactParameters slick{.material = "ptfe", .friction = 0.05};
  slick.oiled = true;
  EXPECT_EQ(combine(slick, slick, {}).friction, 0.05) << "oil makes nothing rougher";
}

constexpr double kRadius = 0.05;

WorldDescription rolling_ball(double mass, double lever, double angle) {
  ContactParameters surface = with_friction(0.6);
  surface.rolling = lever;
  WorldDescription description;
  description.physics.rest = false;
  description.physics.gravity = gravity_on_slope(angle);
  description.objects.push_back(ground());
  description.objects.push_back(part("part", kinematics::Sphere{kRadius}, mass, {0.0, 0.0, kRadius}));
  description.objects.back().contact = surface;
  return description;
}

TEST(Friction, ABallRollsDownASlopeLessItsRollingResistance) {
  for (const double mass : {0.1, 1.0, 10.0}) {
    for (const double lever : {0.0, 0.0005, 0.002}) {
      const double angle = 0.1;
      World world = built(rolling_ball(mass, lever, angle));
      run_for(world, 0.5);
      const double a = place_of(world, "part").x();
      run_for(world, 0.5);
      const double b = place_of(world, "part").x();
      run_for(world, 0.5);
      const double measured = (place_of(world, "part").x() - 2.0 * b + a) / (0.5 * 0.5);
      const double expected = 5.0 / 7.0 * kGravity * (std::sin(angle) - lever / kRadius * std::cos(angle));
      EXPECT_NEAR(measured, expected, 0.005 * expected) << mass << " kg, " << lever << " m";
    }
  }
}

TEST(Friction, ABallStaysOnASlopeThatItsRollingResistanceHolds) {
  for (const double mass : {0.1, 1.0, 10.0}) {
    const double lever = 0.002;
    World world = built(rolling_ball(mass, lever, std::atan(0.9 * lever / kRadius)));
    run_for(world, 2.0);
    const Vector3d before = place_of(world, "part");
    run_for(world, 3.0);
    EXPECT_LT((place_of(world, "part") - before).norm(), 3e-6) << mass;
    EXPECT_LT(std::abs(before.x()), 5e-4) << mass;
    World steeper = built(rolling_ball(mass, lever, std::atan(1.5 * lever / kRadius)));
    run_for(steeper, 3.0);
    EXPECT_GT(place_of(steeper, "part").x(), 0.3) << mass;
  }
}

}  // namespace
}  // namespace takt::sim::test
