// Objects with bores and chamfers: distances, volumes, masses.
#include "core/world/object.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace takt::world {
namespace {

using Eigen::Vector3d;

Bore bore_at(const Vector3d& mouth, double radius, double depth, double chamfer) {
  Bore bore{.radius = radius, .depth = depth, .chamfer = chamfer};
  bore.X_SB.translation() = mouth;
  return bore;
}

/// 100 x 80 x 40 mm with a blind bore and one that goes through from the side, off the middle.
Object::Part block() {
  Object::Part part{.shape = Box{{0.1, 0.08, 0.04}}};
  part.bores.push_back(bore_at({0.02, 0.01, 0.02}, 0.008, 0.015, 0.001));
  Bore across = bore_at({-0.02, -0.04, 0.0}, 0.006, Bore::kThrough, 0.0015);
  across.X_SB.rotate(Eigen::AngleAxisd(std::numbers::pi / 2.0, Vector3d::UnitX()));
  part.bores.push_back(across);
  return part;
}

Object::Part pin() { return {.shape = Cylinder{0.01, 0.05}, .X_OS = Eigen::Isometry3d::Identity(), .chamfer = 0.002}; }

Object object_of(const Object::Part& part) { return {.name = "part", .parts = {part}}; }

TEST(Object, IsEmptyWhereItHasABore) {
  const Object object = object_of(block());
  EXPECT_NEAR(signed_distance(object, {0.02, 0.01, 0.01}), 0.005, 1e-12) << "the bottom is nearer than the wall";
  EXPECT_NEAR(signed_distance(object, {0.02, 0.015, 0.008}), 0.003, 1e-12) << "the wall and the bottom";
  EXPECT_NEAR(signed_distance(object, {0.02, 0.01, 0.003}), -0.002, 1e-12) << "below the bottom";
  EXPECT_NEAR(signed_distance(object, {-0.02, 0.03, 0.0}), 0.006, 1e-12) << "through from the side";
  EXPECT_NEAR(signed_distance(object, {0.02, 0.01, 0.06}), std::hypot(0.04, 0.009), 1e-12) << "above: the rim";
  EXPECT_NEAR(signed_distance(object_of(pin()), {0.01, 0.0, 0.025}), std::sqrt(2.0) * 0.001, 1e-12) << "a chamfer";
}

/// Volume, centre and inertia of points drawn in a box around it that are inside.
MassProperties sampled(const Object& object, const Vector3d& half, int count) {
  Random random(3, "mass");
  MassProperties sum;
  std::vector<Vector3d> inside;
  for (int i = 0; i < count; ++i) {
    const Vector3d p(random.uniform(-half.x(), half.x()), random.uniform(-half.y(), half.y()),
                     random.uniform(-half.z(), half.z()));
    if (signed_distance(object, p) < 0.0) inside.push_back(p);
  }
  sum.mass = 8.0 * half.prod() * static_cast<double>(inside.size()) / count;
  for (const Vector3d& p : inside) sum.p_OC += p / static_cast<double>(inside.size());
  for (const Vector3d& p : inside) {
    const Vector3d r = p - sum.p_OC;
    sum.I_C += (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose()) / static_cast<double>(inside.size());
  }
  return sum;
}

TEST(Object, MassIsWhereMaterialIs) {
  for (const auto& [part, half] : {std::pair(block(), Vector3d(0.05, 0.04, 0.02)), {pin(), {0.01, 0.01, 0.025}}}) {
    const MassProperties exact = spread_mass({part}, 1.0);
    const MassProperties found = sampled(object_of(part), half, 400'000);
    EXPECT_NEAR(volume(part), found.mass, 0.005 * found.mass);
    EXPECT_DOUBLE_EQ(exact.mass, 1.0);
    EXPECT_LT((exact.p_OC - found.p_OC).norm(), 1e-4);
    EXPECT_LT((exact.I_C - found.I_C).cwiseAbs().maxCoeff(), 0.005 * found.I_C.diagonal().maxCoeff());
  }
}

TEST(Object, ATubeIsTwoCylinders) {
  Object::Part tube{.shape = Cylinder{0.02, 0.1}};
  tube.bores.push_back(bore_at({0, 0, 0.05}, 0.015, Bore::kThrough, 0.0));
  const double outer = 0.02 * 0.02, inner = 0.015 * 0.015;
  EXPECT_NEAR(volume(tube), std::numbers::pi * (outer - inner) * 0.1, 1e-15);
  const MassProperties body = spread_mass({tube}, 2.0);
  EXPECT_NEAR(body.I_C(2, 2), 0.5 * 2.0 * (outer + inner), 1e-12);
  EXPECT_NEAR(body.I_C(0, 0), 2.0 * (3.0 * (outer + inner) + 0.1 * 0.1) / 12.0, 1e-12);
  EXPECT_LT(body.p_OC.norm(), 1e-12);
}

}  // namespace
}  // namespace takt::world
