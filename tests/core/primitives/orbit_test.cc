// Where a camera looks from, what an arm can reach, and what is left of a correction.
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/pose_error.h"
#include "tests/core/primitives/environment.h"
#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using net::Boolean;
using net::Frame;
using net::JointArray;
using net::Real;
using net::Twist;
using net::Vector;

/// What OrbitFrame is given at a time, all of it in steady motion.
struct OrbitMotion {
  Vector p{0.4, -0.1, 0.3}, v{0.05, -0.02, 0.08}, w{0.1, 0.2, -0.3};
  double distance = 0.5, azimuth = 0.7, elevation = 0.9;
  double distance_rate = -0.1, azimuth_rate = 0.3, elevation_rate = 0.2;

  PrimitiveHarness at(double t) const {
    PrimitiveHarness orbit("OrbitFrame", {{"roll", 0.3}});
    Frame center = Frame::Identity(), axes = Frame::Identity();
    center.translation() = p + t * v;
    axes.linear() = Eigen::AngleAxisd(t * w.norm(), w.normalized()).toRotationMatrix();
    orbit.set("center", center).set("center_twist", Twist{.linear = v, .angular = {9.0, 9.0, 9.0}});
    orbit.set("axes", axes).set("axes_twist", Twist{.linear = {9.0, 9.0, 9.0}, .angular = w});
    orbit.set("distance", distance + t * distance_rate).set("distance_rate", distance_rate);
    orbit.set("azimuth", azimuth + t * azimuth_rate).set("azimuth_rate", azimuth_rate);
    orbit.set("elevation", elevation + t * elevation_rate).set("elevation_rate", elevation_rate);
    orbit.step();
    return orbit;
  }
};

TEST(OrbitFrame, ThePointIsInTheMiddleAndDownIsDown) {
  OrbitMotion motion;
  PrimitiveHarness orbit = motion.at(0.0);
  const Frame X = *orbit.get<Frame>("frame");
  EXPECT_LT((X.inverse() * motion.p - Vector(0, 0, 0.5)).norm(), 1e-12);
  const Vector out = X.translation() - motion.p;
  EXPECT_NEAR(std::atan2(out.y(), out.x()), 0.7, 1e-12);
  EXPECT_NEAR(std::asin(out.z() / out.norm()), 0.9, 1e-12);
  const Eigen::Matrix3d level = X.linear() * Eigen::AngleAxisd(-0.3, Vector::UnitZ()).toRotationMatrix();
  EXPECT_NEAR(level(2, 0), 0.0, 1e-12) << "without its roll x is level";
  EXPECT_LT(level(2, 1), 0.0) << "and y points down";
}

TEST(OrbitFrame, ItsTwistIsTheDerivativeOfItsPose) {
  constexpr double h = 1e-5;
  const OrbitMotion motion;
  PrimitiveHarness now = motion.at(0.0), before = motion.at(-h), after = motion.at(h);
  const kinematics::Vector6 way = kinematics::pose_error(*before.get<Frame>("frame"), *after.get<Frame>("frame"));
  const Twist V = *now.get<Twist>("twist");
  EXPECT_LT((way.head<3>() / (2 * h) - V.linear).norm(), 1e-8);
  EXPECT_LT((way.tail<3>() / (2 * h) - V.angular).norm(), 1e-8);
}

TEST(OrbitFrame, AtThePointItselfThereIsNone) {
  OrbitMotion motion;
  motion.distance = 0.0;
  EXPECT_FALSE(motion.at(0.0).get<Frame>("frame"));
  EXPECT_FALSE(motion.at(0.0).get<Twist>("twist"));
}

TEST(FrameReach, KnowsWhatTheArmCanReachWhateverItDoes) {
  DeviceEnvironment environment;
  const auto& arm = environment.arm->description();
  Random random(3);
  int reached = 0;
  constexpr int kPoses = 40;
  for (int i = 0; i < kPoses; ++i) {
    kinematics::JointVector q = arm.home;
    for (double& one : q) one += random.uniform(-0.5, 0.5);
    PrimitiveHarness reach("FrameReach",
                           {{"device", "arm"}, {"tool", {{"position", {0, 0, 0}}, {"quaternion", {1, 0, 0, 0}}}}},
                           {.environment = &environment});
    reach.set("q", JointArray(arm.home)).set("frame", Frame(arm.chain->forward(q)));
    for (int cycle = 0; cycle < 30; ++cycle) reach.step();
    reached += reach.get<Boolean>("reachable") == true ? 1 : 0;
  }
  EXPECT_EQ(reached, kPoses);
}

TEST(FrameReach, WhatIsTooFarAwayIsNotAndComesBack) {
  DeviceEnvironment environment;
  const auto& arm = environment.arm->description();
  PrimitiveHarness reach("FrameReach", {{"device", "arm"}}, {.environment = &environment});
  Frame near = arm.chain->forward(arm.home) * environment.arm->tool().X_FT, away = near;
  away.translation().x() += 3.0;
  reach.set("q", JointArray(arm.home)).set("frame", away);
  for (int cycle = 0; cycle < 500; ++cycle) EXPECT_NE(reach.step().get<Boolean>("reachable"), true);
  reach.set("frame", near);
  for (int cycle = 0; cycle < 200; ++cycle) reach.step();
  EXPECT_EQ(reach.get<Boolean>("reachable"), true);
}

TEST(CorrectTwist, OnlyTheCorrectionIsShortenedAndEachPartByItself) {
  const auto corrected = [](const Twist& base, const Twist& correction) {
    return *PrimitiveHarness("CorrectTwist", {{"linear_max", 1.0}, {"angular_max", 0.5}})
                .set("base", base)
                .set("correction", correction)
                .step()
                .get<Twist>("value");
  };
  const Twist base{.linear = {0.6, 0.0, 0.0}, .angular = {0.0, 0.0, 0.0}};
  const Twist far = corrected(base, {.linear = {0.0, 7.0, 0.0}, .angular = {0.0, 0.0, 30.0}});
  EXPECT_LT((far.linear - Vector(0.6, 0.8, 0.0)).norm(), 1e-12);
  EXPECT_LT((far.angular - Vector(0.0, 0.0, 0.5)).norm(), 1e-12);
  const Twist little = corrected(base, {.linear = {0.1, 0.0, 0.0}, .angular = {0.0, 0.1, 0.0}});
  EXPECT_LT((little.linear - Vector(0.7, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_LT((little.angular - Vector(0.0, 0.1, 0.0)).norm(), 1e-12);
  const Twist fast = corrected({.linear = {2.0, 0.0, 0.0}, .angular = {}}, {.linear = {0.0, 1.0, 0.0}, .angular = {}});
  EXPECT_LT((fast.linear - Vector(1.0, 0.0, 0.0)).norm(), 1e-12) << "what is followed is too fast itself";
}

}  // namespace
}  // namespace takt::test
