// Family "overlay": the derivatives are those of the values, and it begins and ends at rest.
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/primitive_harness.h"

namespace takt {
namespace {

using test::PrimitiveHarness;

struct Sample {
  double value, velocity, acceleration;
};

Sample weave_at(double time, double rate = 1.0, double change = 0.0, double begin = 0.0) {
  PrimitiveHarness weave("Weave",
                         {{"amplitude", 0.01}, {"frequency", 3.0}, {"begin", begin}, {"duration", 2.0}, {"ramp", 0.4}});
  weave.set("time", time).set("rate", rate).set("rate_derivative", change).step();
  return {*weave.get<double>("value"), *weave.get<double>("velocity"), *weave.get<double>("acceleration")};
}

TEST(Weave, DerivativesAreThoseOfTheValue) {
  constexpr double h = 1e-5;
  for (double t = 0.05; t < 2.0; t += 0.11) {
    const Sample before = weave_at(t - h), now = weave_at(t), after = weave_at(t + h);
    EXPECT_NEAR(now.velocity, (after.value - before.value) / (2 * h), 1e-6) << t;
    EXPECT_NEAR(now.acceleration, (after.velocity - before.velocity) / (2 * h), 1e-4) << t;
  }
}

TEST(Weave, BeginsAndEndsAtRestAndReachesItsAmplitude) {
  for (const double t : {0.0, 2.0}) {
    const Sample end = weave_at(t);
    EXPECT_EQ(end.value, 0.0);
    EXPECT_EQ(end.velocity, 0.0);
    EXPECT_EQ(end.acceleration, 0.0);
  }
  double most = 0.0;
  for (double t = 0.0; t < 2.0; t += 1e-2) most = std::max(most, std::abs(weave_at(t).value));
  EXPECT_NEAR(most, 0.01, 1e-4);
}

TEST(Weave, LiesWhereItBeginsAndIsNothingBeforeAndAfter) {
  for (const double t : {0.3, 0.77, 1.6}) {
    const Sample there = weave_at(t + 5.0, 0.7, 1.3, 5.0), here = weave_at(t, 0.7, 1.3);
    EXPECT_NEAR(there.value, here.value, 1e-14);
    EXPECT_NEAR(there.velocity, here.velocity, 1e-12);
    EXPECT_NEAR(there.acceleration, here.acceleration, 1e-10);
  }
  for (const double t : {0.0, 4.9, 5.0, 7.0, 7.1, 100.0}) {
    const Sample outside = weave_at(t, 1.0, 0.0, 5.0);
    EXPECT_EQ(outside.value, 0.0) << t;
    EXPECT_EQ(outside.velocity, 0.0) << t;
    EXPECT_EQ(outside.acceleration, 0.0) << t;
  }
}

TEST(Weave, SlowsDownWithThePath) {
  const Sample full = weave_at(0.9), half = weave_at(0.9, 0.5), braking = weave_at(0.9, 0.5, -2.0);
  EXPECT_EQ(half.value, full.value);
  EXPECT_NEAR(half.velocity, 0.5 * full.velocity, 1e-15);
  EXPECT_NEAR(half.acceleration, 0.25 * full.acceleration, 1e-12);
  EXPECT_NEAR(braking.acceleration, 0.25 * full.acceleration - 2.0 * full.velocity, 1e-12);
}

/// A frame that turns and moves, with an offset that grows.
TEST(OffsetFrame, TwistAndAccelerationAreTheDerivativesOfTheFrame) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -1).normalized();
  const auto at = [&](double t) {
    struct {
      Eigen::Isometry3d frame;
      net::Twist twist, acceleration;
    } out;
    net::Frame frame = net::Frame::Identity();
    frame.translate(Eigen::Vector3d(0.3 * t, 0.1 * t * t, 0.2)).rotate(Eigen::AngleAxisd(0.5 * t * t, axis));
    PrimitiveHarness offset("OffsetFrame", {{"direction", {0.0, 1.0, 0.5}}});
    offset.set("frame", frame)
        .set("twist", net::Twist{.linear = {0.3, 0.2 * t, 0}, .angular = axis * t})
        .set("acceleration", net::Twist{.linear = {0, 0.2, 0}, .angular = axis})
        .set("offset", 0.1 * t * t)
        .set("offset_velocity", 0.2 * t)
        .set("offset_acceleration", 0.2)
        .step();
    out.frame = *offset.get<net::Frame>("moved_frame");
    out.twist = *offset.get<net::Twist>("moved_twist");
    out.acceleration = *offset.get<net::Twist>("moved_acceleration");
    return out;
  };
  constexpr double h = 1e-5;
  for (const double t : {0.2, 0.7, 1.3}) {
    const Eigen::Vector3d v = (at(t + h).frame.translation() - at(t - h).frame.translation()) / (2 * h);
    const Eigen::Vector3d a = (at(t + h).twist.linear - at(t - h).twist.linear) / (2 * h);
    EXPECT_LT((at(t).twist.linear - v).norm(), 1e-8);
    EXPECT_LT((at(t).acceleration.linear - a).norm(), 1e-6);
    EXPECT_TRUE(at(t).twist.angular.isApprox(axis * t, 1e-12));
  }
}

constexpr double kPeriod = 1e-3;
const nlohmann::ordered_json kBounds{
    {"lower", -0.004}, {"upper", 0.003}, {"velocity_max", 0.02}, {"acceleration_max", 0.3}, {"jerk_max", 15.0}};

TEST(BoundedOffset, KeepsRangeAndBoundsForAnyWish) {
  for (int seed = 1; seed <= 20; ++seed) {
    Random random(seed, "offset");
    PrimitiveHarness offset("BoundedOffset", kBounds);
    offset.set("rest", false);
    double before = 0.0, rate_before = 0.0, acceleration_before = 0.0;
    for (int i = 0; i < 3000; ++i) {
      if (random.unit() < 0.01 || i == 0) offset.set("velocity", random.uniform(-0.05, 0.05));
      offset.step();
      const double value = *offset.get<double>("value"), rate = *offset.get<double>("rate"),
                   acceleration = *offset.get<double>("acceleration");
      ASSERT_GE(value, -0.004) << seed << " " << i;
      ASSERT_LE(value, 0.003) << seed << " " << i;
      ASSERT_LE(std::abs(rate), 0.02 * (1 + 1e-9));
      ASSERT_LE(std::abs(acceleration), 0.3 * (1 + 1e-9));
      ASSERT_LE(std::abs(acceleration - acceleration_before), 15.0 * kPeriod * (1 + 1e-6));
      ASSERT_NEAR(value - before, 0.5 * (rate + rate_before) * kPeriod, 1e-8) << "a rate is the change of the value";
      before = value;
      rate_before = rate;
      acceleration_before = acceleration;
    }
  }
}

TEST(BoundedOffset, GetsNearTheEndOfItsRangeAndStandsThere) {
  PrimitiveHarness offset("BoundedOffset", kBounds);
  offset.set("rest", false).set("velocity", 0.02);
  for (int i = 0; i < 2000; ++i) offset.step();
  EXPECT_NEAR(*offset.get<double>("value"), 0.003, 2e-5);
  EXPECT_NEAR(*offset.get<double>("rate"), 0.0, 1e-3);
}

TEST(BoundedOffset, SaysWhenItsRangeHoldsItBack) {
  PrimitiveHarness offset("BoundedOffset", kBounds);
  offset.set("rest", false).set("velocity", 0.004);
  for (int i = 0; i < 300; ++i) offset.step();
  EXPECT_EQ(offset.get<bool>("held_back"), false);
  for (int i = 0; i < 1500; ++i) offset.step();
  EXPECT_EQ(offset.get<bool>("held_back"), true);
  offset.set("velocity", -0.004).step();
  EXPECT_EQ(offset.get<bool>("held_back"), false) << "back it may go";
  offset.set("velocity", 0.004).set("rest", true).step();
  EXPECT_EQ(offset.get<bool>("held_back"), false) << "nobody wants to go anywhere";
}

TEST(BoundedOffset, RestAndNullBringItToRestWhereItIs) {
  for (const int way : {0, 1, 2}) {
    PrimitiveHarness offset("BoundedOffset", kBounds);
    offset.set("rest", false).set("velocity", 0.01);
    for (int i = 0; i < 150; ++i) offset.step();
    ASSERT_GT(*offset.get<double>("rate"), 0.005);
    EXPECT_EQ(offset.get<bool>("standing"), false);
    const double there = *offset.get<double>("value");
    if (way == 0) offset.set("rest", true);
    if (way == 1) offset.set_null("velocity");
    if (way == 2) offset.set_null("rest");
    for (int i = 0; i < 300; ++i) offset.step();
    EXPECT_EQ(offset.get<bool>("standing"), true) << way;
    const double stood = *offset.get<double>("value");
    EXPECT_GT(stood, there);
    EXPECT_LT(stood, there + 5e-4) << "no way back, and no jump";
    offset.step();
    EXPECT_EQ(*offset.get<double>("value"), stood);
  }
}

TEST(BoundedOffset, BeginsAtRest) {
  PrimitiveHarness offset("BoundedOffset", kBounds);
  offset.set("rest", false).set("velocity", 0.02).step();
  EXPECT_LT(*offset.get<double>("value"), 1e-8);
  EXPECT_NEAR(*offset.get<double>("acceleration"), 15.0 * kPeriod, 1e-12) << "it has run for one period";
}

}  // namespace
}  // namespace takt
