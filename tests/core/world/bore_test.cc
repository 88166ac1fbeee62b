// Distances to surfaces of revolution: a bore in a plate, a chamfered cylinder.
#include "core/world/bore.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace takt::world {
namespace {

/// A blind bore: radius 10, depth 30, chamfer 2, in mm.
Revolved blind() {
  Bore bore;
  bore.radius = 0.01;
  bore.depth = 0.03;
  bore.chamfer = 0.002;
  return material_around(bore, 0.05);
}

TEST(Bore, DistancesToWallBottomChamferAndFace) {
  const Revolved material = blind();
  EXPECT_NEAR(material.nearest({0.0, 0.007, -0.015}).distance, 0.003, 1e-12);
  EXPECT_NEAR(material.nearest({0.0, -0.011, -0.015}).distance, -0.001, 1e-12);
  EXPECT_NEAR(material.nearest({0.001, 0.0, -0.029}).distance, 0.001, 1e-12);
  EXPECT_NEAR(material.nearest({0.03, 0.0, 0.004}).distance, 0.004, 1e-12);
  EXPECT_NEAR(material.nearest({0.03, 0.0, -0.004}).distance, -0.004, 1e-12);
  // Half way down the chamfer, 1 mm off along its normal.
  const double s = std::sqrt(0.5) * 0.001;
  EXPECT_NEAR(material.nearest({0.011 - s, 0.0, -0.001 + s}).distance, 0.001, 1e-12);
  EXPECT_NEAR(material.nearest({0.011 + s, 0.0, -0.001 - s}).distance, -0.001, 1e-12);
  EXPECT_TRUE(material.nearest({0.0, 0.0, -0.031}).flat);
  EXPECT_FALSE(material.nearest({0.0, 0.0105, -0.015}).flat);
  EXPECT_TRUE(material.nearest({0.012, 0.0, 0.001}).edge);
}

TEST(Bore, AThroughBoreHasAChamferAtBothEnds) {
  Bore bore;
  bore.radius = 0.01;
  bore.chamfer = 0.002;
  const Revolved material = material_around(bore, 0.05);
  for (const double z : {-0.001, -0.049}) {
    EXPECT_NEAR(material.nearest({0.0108, 0.0, z}).distance, 0.0002 * std::sqrt(0.5), 1e-12) << z;
    EXPECT_NEAR(material.nearest({0.0112, 0.0, z}).distance, -0.0002 * std::sqrt(0.5), 1e-12) << z;
  }
  EXPECT_NEAR(material.nearest({0.0, 0.0, -0.06}).distance, std::hypot(0.011, 0.011), 1e-12);
  EXPECT_NEAR(material.nearest({0.03, 0.0, -0.052}).distance, 0.002, 1e-12);
}

TEST(Bore, NormalsAreTheSlopeOfTheDistance) {
  const Revolved cylinder = chamfered_cylinder(0.015, 0.06, 0.001);
  const Revolved hole = blind();
  Random random(7, "points");
  int inside = 0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d p(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), random.uniform(-0.04, 0.01));
    for (const Revolved* solid : {&cylinder, &hole}) {
      const SurfacePoint surface = solid->nearest(p);
      inside += surface.distance < 0.0 ? 1 : 0;
      EXPECT_NEAR(surface.normal.norm(), 1.0, 1e-9);
      // From the nearest point on, along the normal, the distance grows as the way.
      const Eigen::Vector3d on = p - surface.distance * surface.normal;
      EXPECT_NEAR(solid->nearest(on).distance, 0.0, 1e-12);
      // Not in the corner at the bottom of the hole, seen from the material.
      if (surface.edge && surface.distance < 0.0) continue;
      EXPECT_NEAR(solid->nearest(on + 1e-6 * surface.normal).distance, 1e-6, 1e-9);
    }
  }
  EXPECT_GT(inside, 1000);
}

}  // namespace
}  // namespace takt::world
