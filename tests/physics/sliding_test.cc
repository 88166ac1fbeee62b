// Sliding: Coulomb's force, whatever the number of contact points and shapes.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/physics/parts.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kSlope = 30.0 * M_PI / 180.0;
constexpr double kMu = 0.3;

/// A square raster of boxes side by side, as feet of one body.
ObjectDescription feet(int along) {
  ObjectDescription object = part("part", kinematics::Box{{0.04, 0.04, 0.02}}, 1.0, {0.0, 0.0, 0.01});
  object.shapes.clear();
  for (int i = 0; i < along * along; ++i) {
    ObjectGeometry foot{.shape = kinematics::Box{{0.04, 0.04, 0.02}}};
    foot.X_OG.translation() =
        Vector3d(0.05 * (i % along - 0.5 * (along - 1)), 0.05 * (i / along - 0.5 * (along - 1)), 0.0);
    object.shapes.push_back(foot);
  }
  return object;
}

ObjectDescription three_balls() {
  ObjectDescription object = part("part", kinematics::Sphere{0.01}, 1.0, {0.0, 0.0, 0.01});
  object.shapes.clear();
  for (int i = 0; i < 3; ++i) {
    ObjectGeometry ball{.shape = kinematics::Sphere{0.01}};
    const double angle = 2.0 * M_PI / 3.0 * i + 0.1;
    ball.X_OG.translation() = 0.05 * Vector3d(std::cos(angle), std::sin(angle), 0.0);
    object.shapes.push_back(ball);
  }
  return object;
}

WorldDescription sliding(const ObjectDescription& object, double mass, double friction) {
  WorldDescription description;
  description.objects.push_back(ground(with_friction(friction)));
  description.objects.push_back(object);
  description.objects.back().mass = mass;
  description.objects.back().contact.friction = friction;
  return description;
}

/// Acceleration along x between 0.2 and 1 s, from three places: whatever speed it had.
double acceleration(World& world) {
  run_for(world, 0.2);
  const double a = place_of(world, "part").x();
  run_for(world, 0.4);
  const double b = place_of(world, "part").x();
  run_for(world, 0.4);
  return (place_of(world, "part").x() - 2.0 * b + a) / (0.4 * 0.4);
}

TEST(Sliding, DownASlopeAsFastWithManyContactsAsWithFew) {
  const double expected = kGravity * (std::sin(kSlope) - kMu * std::cos(kSlope));
  const auto measure = [&](const ObjectDescription& object, double mass) {
    WorldDescription description = sliding(object, mass, kMu);
    description.physics.gravity = gravity_on_slope(kSlope);
    World world = built(description);
    return acceleration(world);
  };
  for (const double mass : {0.1, 1.0, 10.0}) {
    for (const int along : {1, 2, 3, 4}) {
      EXPECT_NEAR(measure(feet(along), mass), expected, 0.005 * expected)
          << along * along << " feet, " << mass << " kg";
    }
    EXPECT_NEAR(measure(three_balls(), mass), expected, 0.005 * expected) << "balls, " << mass << " kg";
    if (mass < 1.0) continue;  // a light cylinder rattles on its rim: 0.6 %
    EXPECT_NEAR(measure(part("part", kinematics::Cylinder{0.05, 0.02}, mass, {0.0, 0.0, 0.01}), mass), expected,
                0.005 * expected)
        << "cylinder, " << mass << " kg";
  }
}

TEST(Sliding, APieceThatIsCutIntoConvexPartsSlidesAsTheWhole) {
  const double expected = kGravity * (std::sin(kSlope) - kMu * std::cos(kSlope));
  ObjectDescription object = part("part", kinematics::Box{{0.04, 0.04, 0.02}}, 1.0, {0.0, 0.0, 0.01});
  object.shapes.clear();
  for (int i = 0; i < 16; ++i) {
    ObjectGeometry piece{.shape = kinematics::Box{{0.01, 0.04, 0.02}}};
    piece.X_OG.translation().x() = 0.01 * (i - 7.5);
    object.shapes.push_back(piece);
  }
  WorldDescription description = sliding(object, 1.0, kMu);
  description.physics.gravity = gravity_on_slope(kSlope);
  World world = built(description);
  EXPECT_NEAR(acceleration(world), expected, 0.005 * expected);
}

TEST(Sliding, IsBrakedOverTheWayThatCoulombSays) {
  for (const double mass : {0.1, 1.0, 10.0}) {
    for (const int along : {1, 3}) {
      if (along > 1 && mass < 1.0) continue;  // a light part hops when it is pushed so hard
      World world = built(sliding(feet(along), mass, kMu));
      run_for(world, 0.3);
      const double pushed = 0.02;
      // Until it goes with 1 m/s.
      world.push(world.body("part"), {mass * (1.0 / pushed + kMu * kGravity), 0.0, 0.0});
      run_for(world, pushed);
      world.push(world.body("part"), Vector3d::Zero());
      run_for(world, 0.001);
      const double a = place_of(world, "part").x();
      run_for(world, 0.001);
      const double b = place_of(world, "part").x();
      const double speed = 1000.0 * (b - a);
      ASSERT_GT(speed, 0.3);
      run_for(world, 1.0);
      const double way = speed * speed / (2.0 * kMu * kGravity);
      // One step more or less at the end of the known speed.
      EXPECT_NEAR(place_of(world, "part").x() - b, way, 0.005 * way + 0.0005 * speed) << mass << " kg, " << along;
    }
  }
}

TEST(Sliding, APuckThatSpinsGoesOnStraightAndStopsBoth) {
  WorldDescription description = sliding(part("part", kinematics::Cylinder{0.05, 0.02}, 1.0, {0, 0, 0.01}), 1.0, 0.2);
  World world = built(description);
  run_for(world, 0.3);
  world.push(world.body("part"), {50.0, 0.0, 0.0}, {0.0, 0.0, 1.0});
  run_for(world, 0.02);
  world.push(world.body("part"), Vector3d::Zero());
  run_for(world, 2.5);
  const Vector3d end = place_of(world, "part");
  EXPECT_GT(end.x(), 0.2);
  EXPECT_LT(std::abs(end.y()), 0.02 * end.x());
  run_for(world, 0.1);
  EXPECT_LT((place_of(world, "part") - end).norm(), 3e-6);
}

}  // namespace
}  // namespace takt::sim::test
