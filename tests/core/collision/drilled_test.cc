// Convex pieces around bores: all of the material, and hardly more.
#include "core/collision/drilled.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/collision/motion_check.h"

namespace takt::collision {
namespace {

using Eigen::Vector3d;
using DrilledPart = world::Object::Part;

world::Bore bore_at(const Vector3d& mouth, double radius, double depth = world::Bore::kThrough) {
  world::Bore bore{.radius = radius, .depth = depth};
  bore.X_SB.translation() = mouth;
  return bore;
}

/// A rack with a row of blind bores, one of them askew about its axis, and one across between them.
DrilledPart rack() {
  DrilledPart part{.shape = world::Box{{0.12, 0.06, 0.03}}};
  for (const double x : {-0.04, -0.01, 0.02, 0.05})
    part.bores.push_back(bore_at({x, 0.005, 0.015}, 0.0033 + 0.02 * std::abs(x), 0.02));
  part.bores[1].X_SB.rotate(Eigen::AngleAxisd(0.3, Vector3d::UnitZ()));
  world::Bore across = bore_at({0.0, -0.03, 0.0}, 0.005);
  across.X_SB.rotate(Eigen::AngleAxisd(std::numbers::pi / 2.0, Vector3d::UnitX()));
  part.bores.push_back(across);
  part.X_OS.translation() = Vector3d(0.01, 0.02, 0.03);
  return part;
}

DrilledPart tube() {
  DrilledPart part{.shape = world::Cylinder{0.02, 0.08}};
  part.bores.push_back(bore_at({0, 0, 0.04}, 0.012));
  return part;
}

/// A part and a small ball that is put to many points.
class Probed {
 public:
  explicit Probed(const DrilledPart& part) : object_{.name = "part", .parts = {part}} {
    scene_.add_object("part", object_.parts, -1, Eigen::Isometry3d::Identity());
    scene_.add_object("ball", {{.shape = world::Sphere{kBall}}}, -1, Eigen::Isometry3d::Identity());
    scene_.find_pairs_that_never_meet();
  }
  static constexpr double kBall = 1e-6;

  [[nodiscard]] double exact(const Vector3d& p) const { return world::signed_distance(object_, p); }
  [[nodiscard]] double of_pieces(const Vector3d& p) const {
    Poses poses(2, Eigen::Isometry3d::Identity());
    poses[1].translation() = p;
    return distance(scene_, poses, 0, 1) + kBall;
  }

 private:
  world::Object object_;
  Scene scene_;
};

TEST(Drilled, ThePiecesHoldTheMaterialAndHardlyMore) {
  for (const DrilledPart& part : {rack(), tube()}) {
    const Probed probed(part);
    Random random(5, "points");
    int inside = 0, in_bores = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vector3d p = part.X_OS * Vector3d(random.uniform(-0.065, 0.065), random.uniform(-0.035, 0.035),
                                              random.uniform(-0.045, 0.045));
      const double exact = probed.exact(p), pieces = probed.of_pieces(p);
      if (exact < -1e-6) {
        EXPECT_LE(pieces, 2e-6) << p.transpose();
        ++inside;
      } else {
        EXPECT_LE(pieces, exact + 1e-4) << p.transpose();  // where bores meet the edge is nearer than the exact bound
        EXPECT_GE(pieces, exact - 3e-4) << p.transpose();
        if (exact < 0.012 && (p - part.X_OS.translation()).cwiseAbs().x() < 0.055) ++in_bores;
      }
    }
    EXPECT_GT(inside, 300);
    EXPECT_GT(in_bores, 50);
  }
}

TEST(Drilled, WhatStandsInABoreDoesNotOverlap) {
  DrilledPart block{.shape = world::Box{{0.1, 0.1, 0.05}}};
  block.bores.push_back(bore_at({0, 0, 0.025}, 0.0155, 0.04));
  const auto gap = [&](double x, double z) {
    Scene scene;
    scene.add_object("block", {block}, -1, Eigen::Isometry3d::Identity());
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() << x, 0.0, z;
    scene.add_object("peg", {{.shape = world::Cylinder{0.015, 0.06}}}, -1, X);
    Poses poses;
    scene.place(scene.start(), poses);
    return signed_distance(scene, poses, 0, 1);
  };
  EXPECT_NEAR(gap(0.0, 0.02), 0.0003, 2e-4) << "half a millimetre of play, less the chords";
  EXPECT_LT(gap(0.0, 0.012), -0.0025) << "it goes 3 mm through the bottom";
  EXPECT_LT(gap(0.002, 0.02), -0.001) << "it is in the wall";
}

TEST(Drilled, APartWithoutBoresIsOneSolid) {
  const auto solids =
      solids_of({.shape = world::Cylinder{0.01, 0.05}, .X_OS = Eigen::Isometry3d::Identity(), .chamfer = 0.001});
  ASSERT_EQ(solids.size(), 1u);
  EXPECT_EQ(solids[0].solid.kind(), Convex::Kind::kCylinder);
}

}  // namespace
}  // namespace takt::collision
