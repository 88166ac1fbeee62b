// Surfaces of revolution: a distance, and which lines of an outline it can come from.
#include "core/world/revolved.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/world/bore.h"

namespace takt::world {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<Revolved> surfaces() {
  Bore blind{.radius = 0.01, .depth = 0.02, .chamfer = 0.001}, through{.radius = 0.01, .chamfer = 0.0};
  return {material_around(blind, 0.05), material_around(through, 0.03), chamfered_cylinder(0.01, 0.03, 0.002),
          chamfered_cylinder(0.01, 0.03, 0.0)};
}

Vector3d point_about(Random& random, double half) {
  return {random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half)};
}

TEST(Revolved, TheNearestPointIsOnTheSurface) {
  Random random(1, "nearest");
  for (const Revolved& surface : surfaces()) {
    for (int i = 0; i < 2000; ++i) {
      const Vector3d p = point_about(random, 0.03);
      const SurfacePoint found = surface.nearest(p);
      EXPECT_EQ(surface.distance(p), found.distance);
      EXPECT_NEAR(found.normal.norm(), 1.0, 1e-12);
      EXPECT_NEAR(surface.distance(p - found.distance * found.normal), 0.0, 1e-12);
      // No nearer point in any other direction.
      const Vector3d other = p + (std::abs(found.distance) - 1e-9) * point_about(random, 1.0).normalized();
      EXPECT_GE(surface.distance(other) * found.distance, -1e-15);
    }
  }
}

TEST(Revolved, LinesThatAreLeftOutChangeNoDistance) {
  Random random(2, "lines");
  int fewer = 0;
  for (const Revolved& surface : surfaces()) {
    for (int i = 0; i < 2000; ++i) {
      const Revolved::Point middle{random.uniform(0.0, 0.03), random.uniform(-0.04, 0.02)};
      const double radius = std::pow(10.0, random.uniform(-6.0, -2.0));
      const Revolved::Lines lines = surface.lines_near(middle, radius);
      fewer += lines != surface.lines_near(middle, 1.0) ? 1 : 0;
      for (int k = 0; k < 10; ++k) {
        const double angle = random.uniform(0.0, 2.0 * std::numbers::pi), far = random.uniform(0.0, radius);
        const Vector2d at(middle.r + far * std::cos(angle), middle.z + far * std::sin(angle));
        if (at.x() < 0.0) continue;
        const Vector3d p(0.6 * at.x(), 0.8 * at.x(), at.y());
        EXPECT_NEAR(surface.distance(p, lines), surface.distance(p), 1e-12);
        EXPECT_NEAR((surface.nearest(p, lines).normal - surface.nearest(p).normal).norm(), 0.0, 1e-5);
      }
    }
  }
  EXPECT_GT(fewer, 4000);
}

/// A cylinder stands on one, the face around a bore is one; the wall and the chamfer are not.
TEST(Revolved, APlaneIsTheOnlyLineNearby) {
  const Revolved around = material_around({.radius = 0.01, .depth = 0.02, .chamfer = 0.001}, 0.05);
  const auto plane = [](const Revolved& surface, double r, double z) {
    return surface.plane(surface.lines_near({r, z}, 1e-4));
  };
  EXPECT_EQ(plane(around, 0.02, -1e-4), 1.0) << "the face";
  EXPECT_EQ(plane(around, 0.001, -0.0199), 1.0) << "the bottom";
  EXPECT_EQ(plane(around, 0.0099, -0.01), 0.0) << "the wall";
  EXPECT_EQ(plane(around, 0.011, 0.0), 0.0) << "the rim of the face";
  const Revolved cylinder = chamfered_cylinder(0.01, 0.03, 0.002);
  EXPECT_EQ(plane(cylinder, 0.003, -0.0149), -1.0);
  EXPECT_EQ(plane(cylinder, 0.003, 0.0151), 1.0);
  EXPECT_EQ(cylinder.plane(Revolved::kAllLines), 0.0);
}

}  // namespace
}  // namespace takt::world
