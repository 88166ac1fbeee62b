#include "core/world/pose_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/reports.h"

namespace takt::world {
namespace {

using takt::test::Reports;

const std::vector<Coordinate> kPlanar{Coordinate::kX, Coordinate::kY, Coordinate::kYaw};
const std::vector<Coordinate> kOnTable{Coordinate::kX, Coordinate::kY, Coordinate::kZ, Coordinate::kYaw};

Object box(double x, double y, double z) { return {"box", {{Box{{x, y, z}}}}}; }

/// A ball of `radius` that touches a surface point of the object from outside along `normal`, given in O.
Contact touch(const Eigen::Isometry3d& X_RO, const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
              double radius) {
  return {"c", X_RO * (point + radius * normal), radius};
}

TEST(SignedDistance, IsExactForEveryShape) {
  EXPECT_NEAR(signed_distance(Shape(Box{{2, 4, 6}}), {2, 3, 3}), std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(signed_distance(Shape(Box{{2, 4, 6}}), {0.5, 0, 0}), -0.5, 1e-15);
  EXPECT_NEAR(signed_distance(Shape(Cylinder{1, 2}), {2, 0, 0}), 1.0, 1e-15);
  EXPECT_NEAR(signed_distance(Shape(Cylinder{1, 2}), {0, 0, 0.75}), -0.25, 1e-15);
  EXPECT_NEAR(signed_distance(Shape(Sphere{1}), {0, 3, 4}), 4.0, 1e-15);
  EXPECT_NEAR(signed_distance(Shape(Capsule{0.5, 2}), {0, 0, 2}), 0.5, 1e-15);
}

TEST(FitPose, RecoversRandomBoxPosesFromFourTouches) {
  Random random(7);
  const Object object = box(0.12, 0.08, 0.05);
  for (int i = 0; i < 500; ++i) {
    Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
    truth.translation() << random.uniform(-0.015, 0.015), random.uniform(-0.015, 0.015), random.uniform(-0.005, 0.005);
    truth.rotate(Eigen::AngleAxisd(random.uniform(-0.09, 0.09), Eigen::Vector3d::UnitZ()));
    const std::vector<Contact> contacts{
        touch(truth, {0, 0, 0.025}, {0, 0, 1}, 0.005), touch(truth, {-0.03, -0.04, 0}, {0, -1, 0}, 0.005),
        touch(truth, {0.03, -0.04, 0}, {0, -1, 0}, 0.005), touch(truth, {-0.06, 0, 0}, {-1, 0, 0}, 0.005)};
    const auto fit = fit_pose(object, contacts, Eigen::Isometry3d::Identity(), kOnTable);
    ASSERT_TRUE(fit.has_value()) << fit.error().to_string();
    EXPECT_TRUE(fit->X_RO.isApprox(truth, 1e-8)) << i;
  }
}

TEST(FitPose, ACylinderNeedsNoYaw) {
  const Object object{"can", {{Cylinder{0.04, 0.1}}}};
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.translation() << 0.01, -0.007, 0;
  const std::vector<Contact> contacts{touch(truth, {0.04, 0, 0}, {1, 0, 0}, 0.003),
                                      touch(truth, {0, 0.04, 0}, {0, 1, 0}, 0.003)};
  const auto fit = fit_pose(object, contacts, Eigen::Isometry3d::Identity(), {Coordinate::kX, Coordinate::kY});
  ASSERT_TRUE(fit.has_value());
  EXPECT_TRUE(fit->X_RO.isApprox(truth, 1e-8));
  const std::vector<Contact> three{contacts[0], contacts[1], touch(truth, {-0.04, 0, 0}, {-1, 0, 0}, 0.003)};
  const auto turned = fit_pose(object, three, Eigen::Isometry3d::Identity(), kPlanar);
  ASSERT_FALSE(turned.has_value());
  EXPECT_THAT(turned.error(), Reports(Code::kNoContact, "", {"yaw"}));
}

TEST(FitPose, SaysWhatIsMissingOrContradictory) {
  const Object object = box(0.1, 0.1, 0.1);
  const auto I = Eigen::Isometry3d::Identity();
  EXPECT_THAT(fit_pose(object, {touch(I, {0, 0, 0.05}, {0, 0, 1}, 0)}, I, kPlanar).error(),
              Reports(Code::kWrongSize, "", {"1", "3"}));
  const std::vector<Contact> wrong{touch(I, {0.07, 0, 0}, {1, 0, 0}, 0), touch(I, {-0.07, 0, 0}, {-1, 0, 0}, 0)};
  EXPECT_THAT(fit_pose(object, wrong, I, {Coordinate::kX}).error(), Reports(Code::kNoContact, ""));
}

}  // namespace
}  // namespace takt::world
