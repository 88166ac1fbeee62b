// Straight lines of the joints with round corners.
#include "core/motion/polyline_leg.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/random_paths.h"
#include "tests/support/reports.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

JointVector joints(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  std::ranges::copy(values, q.data());
  return q;
}

class PolylineLegTest : public testing::Test {
 protected:
  Random random_{17};
  RandomArm arm_{kinematics::test::lwr_urdf(), random_};
  ArmModel model_ = arm_.model();
  JointVector q0_ = joints({0, -0.5, 0, 1.5, 0, -1.0, 0});
};

/// Joints with their first and second derivative by s at both sides of each seam.
TEST_F(PolylineLegTest, IsTwiceContinuouslyDifferentiable) {
  const std::vector<JointVector> points{joints({0.5, -0.7, 0.3, 1.6, 0, -1, 0.2}),
                                        joints({0.5, -0.7, 0.8, 1.0, 0, -1, 0.2}),
                                        joints({-0.2, -0.3, 0.8, 1.0, 0.4, -1, 0})};
  const auto leg = polyline_leg(model_, q0_, points, {0.3, 0.45});
  ASSERT_TRUE(leg) << leg.error().to_string();
  ASSERT_EQ(leg->pieces.size(), 5U);
  EXPECT_EQ(leg->pieces.front().s_begin, 0.0);
  EXPECT_EQ(leg->pieces.back().s_end, 1.0);
  for (std::size_t i = 0; i + 1 < leg->pieces.size(); ++i) {
    const PathPiece &before = leg->pieces[i], &after = leg->pieces[i + 1];
    EXPECT_EQ(before.s_end, after.s_begin);
    const PathPoint at{.s = before.s_end, .ds = 1.0};
    const JointSample a = sample(before.geometry, before.own(at)).joints,
                      b = sample(after.geometry, after.own(at)).joints;
    EXPECT_LT((a.q - b.q).norm(), 1e-12);
    EXPECT_LT((a.dq - b.dq).norm(), 1e-9);
    EXPECT_LT((a.ddq - b.ddq).norm(), 1e-7);
  }
  EXPECT_EQ(sample(leg->pieces.back().geometry, leg->pieces.back().own({.s = 1.0})).joints.q, points.back());
}

TEST_F(PolylineLegTest, NoPartOfACornerIsFasterThanItsBound) {
  for (int i = 0; i < 200; ++i) {
    std::vector<JointVector> points(2, q0_);
    for (JointVector& point : points) {
      for (double& q : point) q += random_.uniform(-1.0, 1.0);
      point = point.cwiseMax(model_.limits.lower).cwiseMin(model_.limits.upper);
    }
    const auto leg = polyline_leg(model_, q0_, points, {random_.uniform(0.01, 0.5)});
    ASSERT_TRUE(leg);
    const auto& corner = std::get<JointCurve>(leg->pieces[1].geometry);
    const JointVector bound = fastest_of(corner);
    for (double u = 0.0; u <= 1.0; u += 0.01)
      EXPECT_TRUE((corner.q.at(u).first.cwiseAbs().array() <= bound.array() + 1e-12).all());
  }
}

TEST_F(PolylineLegTest, SaysAllThatIsWrong) {
  JointVector outside = q0_;
  outside[1] = 100.0;
  const auto bad = polyline_leg(model_, q0_, {outside, q0_}, {0.9});
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error(), Reports(Code::kOutOfRange, "/corners"));
  EXPECT_GE(bad.error().list().size(), 2U);
  const auto twice = polyline_leg(model_, q0_, {q0_, joints({0, 0, 0, 1, 0, -1, 0})}, {0.3});
  ASSERT_FALSE(twice);
  EXPECT_THAT(twice.error(), Reports(Code::kInvalidValue, "/points/0"));
  EXPECT_FALSE(polyline_leg(model_, q0_, {}, {}));
}

}  // namespace
}  // namespace takt::motion::test
