#include "core/collision/narrow_phase.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"

namespace takt::collision {
namespace {

Eigen::Isometry3d shifted(double x, double y, double z) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << x, y, z;
  return X;
}

Separation apart(const Convex& a, const Convex& b, const Eigen::Isometry3d& X) {
  return separation(a, b, X, Eigen::Vector3d::UnitX(), 1e9);
}

TEST(NarrowPhase, DistancesThatAreKnown) {
  const Convex box = Convex::from(world::Box{{0.2, 0.4, 0.6}});
  const Convex ball = Convex::from(world::Sphere{0.05});
  const Convex rod = Convex::from(world::Cylinder{0.03, 0.2});
  const Convex pill = Convex::from(world::Capsule{0.03, 0.2});
  EXPECT_NEAR(apart(box, ball, shifted(0.5, 0, 0)).distance, 0.35, 1e-6);
  EXPECT_NEAR(apart(box, ball, shifted(0.4, 0.6, 0)).distance, 0.5 - 0.05, 1e-6);
  EXPECT_NEAR(apart(ball, rod, shifted(0, 0, 0.3)).distance, 0.3 - 0.05 - 0.1, 1e-6);
  EXPECT_NEAR(apart(rod, pill, shifted(0, 0, 0.4)).distance, 0.4 - 0.1 - 0.1 - 0.03, 1e-6);
  EXPECT_NEAR(apart(box, box, shifted(0, 0, 0.7)).distance, 0.1, 1e-6);
}

TEST(NarrowPhase, OverlapHasNoDistanceButADepth) {
  const Convex box = Convex::from(world::Box{{0.2, 0.2, 0.2}});
  EXPECT_EQ(apart(box, box, shifted(0.19, 0.05, 0)).distance, 0.0);
  EXPECT_NEAR(depth(box, box, shifted(0.19, 0.05, 0)), 0.01, 1e-4);
  EXPECT_EQ(depth(box, box, shifted(0.3, 0, 0)), 0.0);
}

TEST(NarrowPhase, AHullOfTheCornersOfABoxIsTheBox) {
  std::vector<Eigen::Vector3d> points;
  for (int corner = 0; corner < 8; ++corner)
    points.emplace_back(corner & 1 ? 0.1 : -0.1, corner & 2 ? 0.2 : -0.2, corner & 4 ? 0.3 : -0.3);
  points.emplace_back(0.01, 0.02, 0.03);  // inside
  const auto hull = Convex::hull(points);
  ASSERT_TRUE(hull.has_value());
  EXPECT_EQ(hull->corners().size(), 8u);
  EXPECT_EQ(hull->triangles().size(), 36u);
  const Convex box = Convex::from(world::Box{{0.2, 0.4, 0.6}});
  const Convex ball = Convex::from(world::Sphere{0.05});
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Isometry3d X =
        shifted(random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6));
    EXPECT_NEAR(apart(*hull, ball, X).distance, apart(box, ball, X).distance, 1e-5) << i;
  }
}

TEST(NarrowPhase, APlaneIsNoHull) {
  const std::vector<Eigen::Vector3d> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.5, 0.5, 0}};
  EXPECT_FALSE(Convex::hull(flat).has_value());
  EXPECT_FALSE(Convex::hull(std::span(flat).first(3)).has_value());
}

/// What is proven: the axis parts the solids by the distance, so no two of their points can be nearer. And two points
/// that near exist: a walk of one body by the distance along the axis, and a little more, makes them overlap.
TEST(NarrowPhase, DistancesOfRandomSolidsAreProvenFromBothSides) {
  Random random(7);
  std::vector<Convex> solids;
  for (int i = 0; i < 25; ++i) {
    const double a = random.uniform(0.02, 0.2), b = random.uniform(0.02, 0.2), c = random.uniform(0.02, 0.2);
    switch (i % 5) {
      case 0:
        solids.push_back(Convex::from(world::Box{{a, b, c}}));
        break;
      case 1:
        solids.push_back(Convex::from(world::Cylinder{a, b}));
        break;
      case 2:
        solids.push_back(Convex::from(world::Sphere{a}));
        break;
      case 3:
        solids.push_back(Convex::from(world::Capsule{a, b}));
        break;
      default: {
        std::vector<Eigen::Vector3d> points;
        for (int k = 0; k < 40; ++k)
          points.emplace_back(random.uniform(-a, a), random.uniform(-b, b), random.uniform(-c, c));
        solids.push_back(*Convex::hull(points));
      }
    }
  }
  int separate = 0, loose = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Convex& a = solids[static_cast<std::size_t>(random.uniform(0, 25))];
    const Convex& b = solids[static_cast<std::size_t>(random.uniform(0, 25))];
    Eigen::Isometry3d X = shifted(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
    X.linear() = Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
                     .normalized()
                     .toRotationMatrix();
    const Separation found = apart(a, b, X);
    if (found.distance == 0.0) continue;
    ++separate;
    ASSERT_NEAR(gap_along(a, b, X, found.axis_A), found.distance, 1e-12) << i;
    X.translation() -= (found.distance + 1e-4) * found.axis_A;
    if (apart(a, b, X).distance > 1e-4) ++loose;
  }
  EXPECT_GT(separate, 5'000);
  EXPECT_LE(loose, separate / 1000);
}

}  // namespace
}  // namespace takt::collision
