// What the search for contacts leaves out could not have touched, and what it finds is the deepest there is.
#include "sim/contact/solid_view.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "sim/contact/solid_contact.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kTurn = 2.0 * std::numbers::pi;

Pose pose_about(Random& random, double distance, double lean) {
  Pose X = Pose::Identity();
  X.translation() = Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)) * distance;
  const Vector3d axis = Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)).normalized();
  X.linear() = Eigen::AngleAxisd(random.uniform(0.0, lean), axis).toRotationMatrix();
  return X;
}

/// A block of 80 x 80 x 40 mm whose upper face is at z = 20 mm, with bores of 20 mm across.
Solid bored(int bores) {
  std::vector<world::Bore> made;
  for (int i = 0; i < bores; ++i) {
    world::Bore bore{.radius = 0.01, .depth = i % 2 == 0 ? 0.025 : world::Bore::kThrough, .chamfer = 0.001};
    bore.X_SB.translation() = Vector3d(0.025 * (i % 3 - 1), 0.025 * ((i / 3) % 3 - 1), 0.02);
    made.push_back(bore);
  }
  return make_solid(kinematics::Box{{0.08, 0.08, 0.04}}, 0.0, made);
}

SolidView view_of_block(const Solid& solid, const Pose& X_W) {
  return {.shape = SolidView::Shape::kBox,
          .X_W = X_W,
          .size = Vector3d(0.04, 0.04, 0.02),
          .bound = Vector3d(0.04, 0.04, 0.02).norm(),
          .solid = &solid};
}

/// A pin of 19.8 mm across and 30 mm long.
struct Pin {
  Solid solid{.chamfer = 0.001, .bores = {}};
  world::Revolved outline = world::chamfered_cylinder(0.0099, 0.03, 0.001);

  [[nodiscard]] SolidView view(const Pose& X_W) const {
    return {.shape = SolidView::Shape::kCylinder,
            .X_W = X_W,
            .size = Vector3d(0.0099, 0.015, 0.0),
            .bound = std::hypot(0.0099, 0.015),
            .solid = &solid,
            .outline = &outline};
  }
};

TEST(NearSurface, WhatIsLeftOutChangesNoDistance) {
  Random random(1, "near");
  int free = 0, touching = 0;
  for (const int bores : {1, 9, 40}) {
    const Solid solid = bored(bores);
    const SolidView block = view_of_block(solid, Pose::Identity());
    const NearSurface all(block);
    for (int i = 0; i < 3000; ++i) {
      const double radius = std::pow(10.0, random.uniform(-4.0, -1.7));
      const Vector3d middle =
          Vector3d(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), random.uniform(-0.03, 0.05));
      const Pose X_SC = Eigen::Translation3d(middle) * pose_about(random, 0.0, 0.3);
      const EdgeCircle circle{.centre = X_SC.translation(),
                              .u = radius * X_SC.linear().col(0),
                              .v = radius * X_SC.linear().col(1),
                              .axis = X_SC.linear().col(2),
                              .radius = radius};
      const NearSurface ball(all, middle, 1.2 * radius), edge(ball, circle);
      double least = 1.0;
      for (int k = 0; k < 24; ++k) {
        const double angle = random.uniform(0.0, kTurn);
        const Vector3d p = circle.at({std::cos(angle), std::sin(angle)});
        const double wanted = block.distance_in_geom(p);
        least = std::min(least, wanted);
        EXPECT_EQ(block.nearest_in_geom(p).distance, wanted);
        for (const NearSurface* near : {&ball, &edge}) {
          if (near->free()) continue;
          EXPECT_NEAR(near->distance(p), wanted, 1e-12);
          EXPECT_NEAR(near->nearest(p).distance, wanted, 1e-12);
        }
      }
      if (edge.free()) {
        EXPECT_GT(least, 0.0);
      }
      if (ball.free()) {
        EXPECT_TRUE(edge.free());
      }
      free += edge.free() ? 1 : 0;
      touching += least < 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(free, 500);
  EXPECT_GT(touching, 500);
}

/// How deep a circle is in a solid, from many points of it.
double depth_of_circle(const SolidView& solid, const Pose& X_WC, double radius) {
  double depth = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double angle = kTurn * i / 2000;
    const Vector3d p_W = X_WC * Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    depth = std::max(depth, -solid.distance_in_geom(solid.to_geom(p_W)));
  }
  return depth;
}

/// A pin about its bore, at any height and lean: as deep as the deepest point of the edges of both.
TEST(Touches, FindTheDeepestPointOfAllEdges) {
  Random random(2, "touches");
  const Solid solid = bored(9);
  const Pin pin;
  int touching = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose X_W = pose_about(random, 1.0, std::numbers::pi);
    const SolidView block = view_of_block(solid, X_W);
    const int bore = static_cast<int>(random.uniform(0.0, 9.0));
    Pose X_BP = pose_about(random, 1.0, 0.05);
    X_BP.translation() = X_BP.translation().cwiseProduct(Vector3d(5e-4, 5e-4, 0.025));
    const SolidView peg = pin.view(X_W * solid.bores[static_cast<std::size_t>(bore)].X_GB * X_BP);
    double wanted = 0.0;
    for (const double end : {-1.0, 1.0}) {
      const auto rim = [&](double radius, double z) {
        wanted = std::max(wanted, depth_of_circle(block, peg.X_W * Eigen::Translation3d(0, 0, end * z), radius));
      };
      rim(0.0089, 0.015);
      rim(0.0099, 0.014);
    }
    for (const DrilledBore& one : solid.bores) {
      const auto rim = [&](double radius, double z) {
        const Pose X_WC = X_W * one.X_GB * Eigen::Translation3d(0, 0, z);
        wanted = std::max(wanted, depth_of_circle(peg, X_WC, radius));
      };
      rim(0.011, 0.0);
      rim(0.01, -0.001);
      if (!one.through) continue;
      rim(0.011, -0.04);
      rim(0.01, -0.039);
    }
    Touches touches;
    touches.find(block, peg);
    double found = 0.0;
    for (const auto& touch : touches.all()) found = std::max(found, touch.depth);
    // Where two faces cross, the search ends 2.2 um above it at an overlap of 7.5 mm; between the points here it may
    // find a deeper one.
    EXPECT_GT(found, wanted - 3e-6) << i;
    EXPECT_LT(found, wanted + 2e-5) << i;
    touching += wanted > 0.0 ? 1 : 0;
  }
  EXPECT_GT(touching, 100);
  EXPECT_LT(touching, 200);
}

TEST(Touches, NothingIsFoundWhereNothingTouches) {
  const Solid solid = bored(1);
  const SolidView block = view_of_block(solid, Pose::Identity());
  const Pin pin;
  Pose X = Pose::Identity();
  X.translation() = solid.bores[0].X_GB.translation();
  X.translation().z() = 0.013;  // its lower end in the bore, 0.1 mm of play all round
  Touches apart;
  apart.find(block, pin.view(X));
  EXPECT_TRUE(apart.all().empty());
  X.translation().x() += 2e-4;
  Touches aside;
  aside.find(block, pin.view(X));
  EXPECT_FALSE(aside.all().empty());
}

}  // namespace
}  // namespace takt::sim::test
