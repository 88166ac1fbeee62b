// Rotations, frames, twists and wrenches against identities that hold whatever the numbers.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using harness::random_value;
using net::Boolean;
using net::Frame;
using net::JointArray;
using net::Real;
using net::Rotation;
using net::Twist;
using net::Vector;
using net::Wrench;
constexpr auto kModerate = harness::Numbers::kModerate;
constexpr double kHalfTurn = std::numbers::pi;

double apart(const Rotation& a, const Rotation& b) { return a.angularDistance(b); }

TEST(Rotation, LogAndExpAreInverse) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Rotation R = random_value<Rotation>(random);
    const Vector v = *PrimitiveHarness("RotationVector").set("input", R).step().get<Vector>("value");
    EXPECT_LE(v.norm(), kHalfTurn + 1e-12);
    EXPECT_LT(apart(Rotation(Eigen::AngleAxisd(v.norm(), v.normalized())), R), 1e-7);
    EXPECT_LT(apart(*PrimitiveHarness("RotationFromVector").set("input", v).step().get<Rotation>("value"), R), 1e-7);
  }
  for (const double angle : {0.0, 1e-12, 1e-6, 1e-3, 1.0, 3.0, kHalfTurn}) {
    const Vector v = angle * Vector(2, -1, 0.5).normalized();
    const Rotation R = *PrimitiveHarness("RotationFromVector").set("input", v).step().get<Rotation>("value");
    const Vector again = *PrimitiveHarness("RotationVector").set("input", R).step().get<Vector>("value");
    // Half a turn has two axes.
    EXPECT_NEAR(angle < kHalfTurn ? (again - v).norm() : again.cross(v).norm(), 0.0, 1e-12);
    EXPECT_NEAR(again.norm(), angle, 1e-12);
  }
}

TEST(Rotation, SlerpTurnsEvenly) {
  Random random(2);
  for (int i = 0; i < 50; ++i) {
    const Rotation a = random_value<Rotation>(random), b = random_value<Rotation>(random);
    PrimitiveHarness slerp("Slerp");
    slerp.set("a", a).set("b", b);
    for (const double share : {0.0, 0.25, 0.5, 1.0}) {
      const Rotation R = *slerp.set("share", share).step().get<Rotation>("value");
      EXPECT_NEAR(apart(a, R), share * apart(a, b), 1e-7);
      EXPECT_NEAR(apart(R, b), (1.0 - share) * apart(a, b), 1e-7);
    }
  }
}

TEST(Rotation, RpyBothWays) {
  for (const double pitch : {-kHalfTurn / 2, -1.0, 0.0, 0.7, kHalfTurn / 2}) {
    for (const double roll : {-3.0, -0.2, 0.0, 2.0}) {
      for (const double yaw : {-2.5, 0.0, 0.3}) {
        const Rotation R = *PrimitiveHarness("RotationFromRpy")
                                .set("roll", roll)
                                .set("pitch", pitch)
                                .set("yaw", yaw)
                                .step()
                                .get<Rotation>("value");
        const Eigen::Matrix3d expected =
            (Eigen::AngleAxisd(yaw, Vector::UnitZ()) * Eigen::AngleAxisd(pitch, Vector::UnitY()) *
             Eigen::AngleAxisd(roll, Vector::UnitX()))
                .toRotationMatrix();
        EXPECT_LT((R.toRotationMatrix() - expected).norm(), 1e-12);
        PrimitiveHarness back("RotationToRpy");
        back.set("input", R).step();
        const bool upright = std::abs(std::abs(pitch) - kHalfTurn / 2) < 1e-9;
        EXPECT_NEAR(*back.get<Real>("pitch"), pitch, 1e-7);
        if (!upright) {
          EXPECT_NEAR(*back.get<Real>("roll"), roll, 1e-9);
        }
        if (!upright) {
          EXPECT_NEAR(*back.get<Real>("yaw"), yaw, 1e-9);
        }
        const Rotation again = *PrimitiveHarness("RotationFromRpy")
                                    .set("roll", *back.get<Real>("roll"))
                                    .set("pitch", *back.get<Real>("pitch"))
                                    .set("yaw", *back.get<Real>("yaw"))
                                    .step()
                                    .get<Rotation>("value");
        EXPECT_LT(apart(R, again), 1e-7);
      }
    }
  }
}

TEST(Rotation, BetweenDirectionsAndAboutAxes) {
  const Vector a(1, 2, -0.5), b(-3, 0.1, 1);
  const Rotation R = *PrimitiveHarness("RotationBetween").set("from", a).set("to", b).step().get<Rotation>("value");
  EXPECT_LT(((R * a).normalized() - b.normalized()).norm(), 1e-12);
  const Rotation quarter = *PrimitiveHarness("RotationFromAxis")
                                .set("axis", Vector(0, 0, 7))
                                .set("angle", kHalfTurn / 2)
                                .step()
                                .get<Rotation>("value");
  EXPECT_LT((quarter * Vector::UnitX() - Vector::UnitY()).norm(), 1e-12);
  EXPECT_TRUE(
      PrimitiveHarness("RotationFromAxis").set("axis", Vector(0, 0, 0)).set("angle", 1.0).step().is_null("value"));
  PrimitiveHarness parts("RotationComponents");
  parts.set("input", R).step();
  PrimitiveHarness whole("AssembleRotation");
  for (const char* part : {"w", "x", "y", "z"}) whole.set(part, 2.0 * *parts.get<Real>(part));
  EXPECT_LT(apart(*whole.step().get<Rotation>("value"), R), 1e-7);
  const Vector v = *PrimitiveHarness("Rotate").set("rotation", R).set("vector", a).step().get<Vector>("value");
  const Rotation back = *PrimitiveHarness("InverseRotation").set("input", R).step().get<Rotation>("value");
  EXPECT_LT((*PrimitiveHarness("Rotate").set("rotation", back).set("vector", v).step().get<Vector>("value") - a).norm(),
            1e-12);
  EXPECT_LT(apart(*PrimitiveHarness("ComposeRotations").set("left", back).set("right", R).step().get<Rotation>("value"),
                  Rotation::Identity()),
            1e-7);
  EXPECT_NEAR(
      *PrimitiveHarness("RotationAngle").set("a", Rotation::Identity()).set("b", quarter).step().get<Real>("value"),
      kHalfTurn / 2, 1e-12);
}

TEST(FramePrimitives, ADifferenceLeadsFromOneToTheOther) {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Frame a = random_value<Frame>(random, kModerate), b = random_value<Frame>(random, kModerate);
    const Twist way = *PrimitiveHarness("FrameDifference").set("from", a).set("to", b).step().get<Twist>("value");
    const Frame there =
        *PrimitiveHarness("DisplaceFrame").set("frame", a).set("displacement", way).step().get<Frame>("value");
    EXPECT_LT((there.matrix() - b.matrix()).norm(), 1e-7);
    const Frame X_AB = *PrimitiveHarness("RelativeFrame").set("from", a).set("to", b).step().get<Frame>("value");
    EXPECT_LT(((a * X_AB).matrix() - b.matrix()).norm(), 1e-12);
    PrimitiveHarness between("InterpolateFrames");
    between.set("a", a).set("b", b);
    EXPECT_LT((between.set("share", 1.0).step().get<Frame>("value")->matrix() - b.matrix()).norm(), 1e-12);
    const Frame half = *between.set("share", 0.5).step().get<Frame>("value");
    EXPECT_LT((half.translation() - 0.5 * (a.translation() + b.translation())).norm(), 1e-12);
    EXPECT_NEAR(apart(Rotation(a.linear()), Rotation(half.linear())), 0.5 * way.angular.norm(), 1e-7);
    PrimitiveHarness distance("FrameDistance");
    distance.set("a", a).set("b", b).step();
    EXPECT_NEAR(*distance.get<Real>("distance"), (a.translation() - b.translation()).norm(), 1e-12);
    EXPECT_NEAR(*distance.get<Real>("angle"), way.angular.norm(), 1e-12);
    const double d = *distance.get<Real>("distance"), angle = *distance.get<Real>("angle");
    const auto near = [&](double d_max, double angle_max) {
      return PrimitiveHarness("FramesNear", {{"distance_max", d_max}, {"angle_max", angle_max}})
          .set("a", a)
          .set("b", b)
          .step()
          .get<Boolean>("value");
    };
    EXPECT_EQ(near(d + 1e-9, angle + 1e-9), true);
    EXPECT_EQ(near(d - 1e-9, angle + 1e-9), false);
    EXPECT_EQ(near(d + 1e-9, angle - 1e-9), false);
  }
}

/// The power of a wrench on a twist does not depend on the frame in which both are told: the adjoints belong together.
TEST(TwistPrimitives, AdjointsKeepThePower) {
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    const Frame X = random_value<Frame>(random, kModerate);
    const Twist V = random_value<Twist>(random, kModerate);
    const Wrench w = random_value<Wrench>(random, kModerate);
    const Twist V_A = *PrimitiveHarness("TransformTwist").set("frame", X).set("twist", V).step().get<Twist>("value");
    const Wrench w_A =
        *PrimitiveHarness("TransformWrench").set("frame", X).set("wrench", w).step().get<Wrench>("value");
    const double power = *PrimitiveHarness("WrenchPower").set("wrench", w).set("twist", V).step().get<Real>("value");
    EXPECT_NEAR(*PrimitiveHarness("WrenchPower").set("wrench", w_A).set("twist", V_A).step().get<Real>("value"), power,
                1e-11);
    // The same by a shift of the point and a change of axes.
    const Twist turned = *PrimitiveHarness("RotateTwist").set("frame", X).set("twist", V).step().get<Twist>("value");
    const Twist shifted = *PrimitiveHarness("ShiftTwist")
                               .set("twist", turned)
                               .set("point", Vector(-X.translation()))
                               .step()
                               .get<Twist>("value");
    EXPECT_LT((shifted.linear - V_A.linear).norm() + (shifted.angular - V_A.angular).norm(), 1e-12);
  }
}

TEST(TwistPrimitives, LimitsKeepTheDirection) {
  const Twist V{Vector(3, 0, 4), Vector(0, 1, 0)};
  const Twist limited = *PrimitiveHarness("LimitTwist", {{"linear_max", 1.0}, {"angular_max", 5.0}})
                             .set("input", V)
                             .step()
                             .get<Twist>("value");
  EXPECT_NEAR(limited.linear.norm(), 1.0, 1e-12);
  EXPECT_NEAR(limited.angular.norm(), 0.2, 1e-12);  // in the same proportion
  const Wrench w{Vector(3, 0, 4), Vector(0, 1, 0)};
  PrimitiveHarness bound("LimitWrench", {{"force_max", 1.0}, {"torque_max", 5.0}});
  EXPECT_NEAR(bound.set("input", w).step().get<Wrench>("value")->force.norm(), 1.0, 1e-12);
  EXPECT_EQ(bound.get<Wrench>("value")->torque, w.torque);
  EXPECT_EQ(bound.get<Boolean>("limited"), true);
  const Wrench band = *PrimitiveHarness("DeadBandWrench", {{"force", 2.0}, {"torque", 2.0}})
                           .set("input", w)
                           .step()
                           .get<Wrench>("value");
  EXPECT_LT((band.force - 0.6 * w.force).norm(), 1e-12);
  EXPECT_EQ(band.torque, Vector::Zero());
}

TEST(VectorPrimitives, PartsAndDirections) {
  const Vector v(3, -2, 6), d(0, 2, 0);
  PrimitiveHarness split("SplitVector");
  split.set("input", v).set("direction", d).step();
  EXPECT_EQ(split.get<Vector>("along"), Vector(0, -2, 0));
  EXPECT_EQ(split.get<Vector>("across"), Vector(3, 0, 6));
  EXPECT_NEAR(*PrimitiveHarness("AngleBetween")
                   .set("a", Vector(1, 0, 0))
                   .set("b", Vector(-1, 1e-9, 0))
                   .step()
                   .get<Real>("value"),
              kHalfTurn - 1e-9, 1e-12);
  EXPECT_EQ(PrimitiveHarness("Distance").set("a", v).set("b", Vector(0, 0, 0)).step().get<Real>("value"), 7.0);
  EXPECT_LT((*PrimitiveHarness("Normalize").set("input", v).step().get<Vector>("value") - v / 7.0).norm(), 1e-15);
  EXPECT_NEAR(PrimitiveHarness("Normalize").set("input", Vector(1e300, 1e300, 0)).step().get<Vector>("value")->norm(),
              1.0, 1e-12);
  EXPECT_TRUE(PrimitiveHarness("Normalize").set("input", Vector(0, 0, 0)).step().is_null("value"));
  EXPECT_LT(
      (*PrimitiveHarness("LimitVector", {{"length_max", 3.5}}).set("input", v).step().get<Vector>("value") - 0.5 * v)
          .norm(),
      1e-15);
  EXPECT_EQ(
      PrimitiveHarness("InterpolateVectors").set("a", v).set("b", d).set("share", 1.0).step().get<Vector>("value"), d);
}

TEST(JointPrimitives, ElementByElement) {
  const auto joints = [](std::initializer_list<double> values) {
    JointArray all;
    for (const double value : values) all.value[static_cast<std::size_t>(all.size++)] = value;
    return all;
  };
  const JointArray a = joints({1, 2, 3}), b = joints({0.5, -2, 4}), shorter = joints({1});
  const auto of = [&](const char* type, const JointArray& right) {
    return std::move(PrimitiveHarness(type).set("a", a).set("b", right).step());
  };
  EXPECT_EQ(of("AddJoints", b).get<JointArray>("value")->value, joints({1.5, 0, 7}).value);
  EXPECT_EQ(of("SubtractJoints", b).get<JointArray>("value")->value, joints({0.5, 4, -1}).value);
  EXPECT_TRUE(of("AddJoints", shorter).is_null("value"));
  EXPECT_EQ(of("JoinJoints", shorter).get<JointArray>("value")->value, joints({1, 2, 3, 1}).value);
  EXPECT_EQ(PrimitiveHarness("LargestJoint").set("input", joints({1, -5, 3})).step().get<Real>("value"), 5.0);
  PrimitiveHarness band("DeadBandJoints");
  EXPECT_EQ(band.set("input", b).set("width", joints({0.5, 0.5, 1})).step().get<JointArray>("value")->value,
            joints({0, -1.5, 3}).value);
  EXPECT_TRUE(band.set("width", joints({0.5, -0.5, 1})).step().is_null("value"));
  EXPECT_TRUE(band.set("width", shorter).step().is_null("value"));
  EXPECT_EQ(PrimitiveHarness("JointElement").set("input", a).set("index", 2).step().get<Real>("value"), 3.0);
  EXPECT_TRUE(PrimitiveHarness("JointElement").set("input", a).set("index", 3).step().is_null("value"));
  EXPECT_TRUE(PrimitiveHarness("JointElement").set("input", a).set("index", -1).step().is_null("value"));
  EXPECT_EQ(PrimitiveHarness("ReplaceJoint")
                .set("input", a)
                .set("index", 0)
                .set("element", 9.0)
                .step()
                .get<JointArray>("value")
                ->value,
            joints({9, 2, 3}).value);
  EXPECT_EQ(PrimitiveHarness("ScaleJoints").set("joints", a).set("factor", -2.0).step().get<JointArray>("value")->value,
            joints({-2, -4, -6}).value);
  PrimitiveHarness near("JointsNear", {{"tolerance", 4.0}});
  EXPECT_EQ(near.set("a", a).set("b", b).step().get<Boolean>("value"), true);
  EXPECT_EQ(PrimitiveHarness("JointsNear", {{"tolerance", 3.9}}).set("a", a).set("b", b).step().get<Boolean>("value"),
            false);
}

}  // namespace
}  // namespace takt::test
