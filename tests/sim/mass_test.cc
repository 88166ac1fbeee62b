// Masses of parts, a given centre and inertia, models that move freely.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/sim/cell.h"
#include "tests/support/reports.h"

namespace takt::sim::test {
namespace {

/// A bar of 0.2 m on a post that is 20 mm wide, its middle this far beside the post's.
WorldDescription bar_on_post(double aside) {
  WorldDescription world;
  world.objects.push_back(box("post", {0.02, 0.1, 0.2}, {0.0, 0.0, 0.1}));
  ObjectDescription bar;
  bar.name = "bar";
  bar.free = true;
  bar.mass = 0.4;
  bar.shapes.push_back({.shape = kinematics::Box{{0.2, 0.04, 0.02}}});
  bar.mount.X_P.translation() = Eigen::Vector3d(aside, 0.0, 0.21);
  world.objects.push_back(bar);
  return world;
}

bool falls(const WorldDescription& description) {
  World world = make(description);
  for (int i = 0; i < 1500; ++i) EXPECT_TRUE(world.step());
  return world.body_pose(world.body("bar")).translation().z() < 0.2;
}

TEST(Mass, AGivenCentreDecidesWhatTips) {
  EXPECT_FALSE(falls(bar_on_post(0.005)));
  EXPECT_TRUE(falls(bar_on_post(0.02)));
  WorldDescription heavy_end = bar_on_post(0.02);
  kinematics::Inertial& inertial = heavy_end.objects[1].inertial.emplace();
  inertial.mass = 0.4;
  inertial.X_LC.translation().x() = -0.02;
  inertial.I_C = Eigen::Vector3d(6e-5, 1.3e-3, 1.3e-3).asDiagonal();
  EXPECT_FALSE(falls(heavy_end));
  heavy_end.objects[1].inertial->X_LC.translation().x() = -0.04;
  EXPECT_TRUE(falls(heavy_end));
}

TEST(Mass, PartsHaveTheirOwn) {
  WorldDescription description = bar_on_post(0.02);
  ObjectDescription& bar = description.objects[1];
  bar.shapes.clear();
  for (const double side : {-1.0, 1.0}) {
    ObjectGeometry half{.shape = kinematics::Box{{0.1, 0.04, 0.02}}};
    half.X_OG.translation().x() = 0.05 * side;
    half.mass = side < 0.0 ? 0.28 : 0.12;
    bar.shapes.push_back(half);
  }
  // The centre is 20 mm towards the heavier half: over the post.
  EXPECT_FALSE(falls(description));
  std::swap(bar.shapes[0].mass, bar.shapes[1].mass);
  EXPECT_TRUE(falls(description));
  World world = make(description);
  const mjModel* model = world.physics_model();
  const int body = world.body("bar");
  EXPECT_NEAR(model->body_mass[body], 0.4, 1e-12);
  EXPECT_NEAR(model->body_ipos[3 * body], 0.02, 1e-9);
}

TEST(Mass, AnInertiaThatNoSolidHasIsReported) {
  WorldDescription description = bar_on_post(0.0);
  kinematics::Inertial& inertial = description.objects[1].inertial.emplace();
  inertial.mass = 0.4;
  inertial.I_C = Eigen::Vector3d(1e-3, 1e-3, 3e-3).asDiagonal();
  EXPECT_TRUE(takt::test::Reports(Code::kOutOfRange, "/objects/bar")
                  .MatchAndExplain(World::create(description).error(), nullptr));
}

TEST(Mass, AFreeModelFallsAndComesToRest) {
  WorldDescription description;
  description.objects.push_back(box("floor", {1.0, 1.0, 0.1}, {0.0, 0.0, -0.05}));
  RobotDescription probe;
  probe.name = "probe";
  probe.model = model("probe_ball");
  probe.free = true;
  probe.mount.X_P.translation().z() = 0.3;
  description.robots.push_back(probe);
  World world = make(description);
  const int body = world.body("probe/" + probe.model->root().name);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(world.step());
  EXPECT_NEAR(world.body_pose(body).translation().z(), 0.3 - 0.5 * 9.81 * 0.01, 6e-4);
  for (int i = 0; i < 4000; ++i) ASSERT_TRUE(world.step());
  const Eigen::Vector3d rest = world.body_pose(body).translation();
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(world.step());
  EXPECT_LT((world.body_pose(body).translation() - rest).norm(), 1e-3);
  EXPECT_GT(rest.z(), -0.01);
}

}  // namespace
}  // namespace takt::sim::test
