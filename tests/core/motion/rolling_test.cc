// Planned motions of a base that cannot go sideways.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/kinematics/inverse.h"
#include "core/motion/leg.h"
#include "core/motion/planner.h"
#include "tests/core/kinematics/robots.h"
#include "tests/support/reports.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

kinematics::Chain rolling_base() {
  const auto slide = [](const char* name, const char* parent, const char* child, const char* axis) {
    return std::string("<joint name='") + name + "' type='prismatic'><parent link='" + parent + "'/><child link='" +
           child + "'/><axis xyz='" + axis + "'/><limit lower='-50' upper='50' velocity='0.8' effort='100'/></joint>";
  };
  return kinematics::test::chain_of("<robot name='rolling'><link name='base'/><link name='a'/><link name='b'/>" +
                                    slide("x", "base", "a", "1 0 0") + slide("y", "a", "b", "0 1 0") +
                                    "<joint name='yaw' type='continuous'><parent link='b'/><child link='flange'/>"
                                    "<axis xyz='0 0 1'/><limit velocity='1' effort='40'/></joint>"
                                    "<link name='flange'/></robot>");
}

JointVector place_of(double x, double y, double yaw) {
  JointVector q(3);
  q << x, y, yaw;
  return q;
}

class Rolling : public testing::Test {
 protected:
  Rolling() : inverse(*kinematics::InverseKinematics::create(chain)) {
    limits = {.lower = chain.lower(),
              .upper = chain.upper(),
              .velocity = place_of(0.6, 0.6, 1.0),
              .acceleration = place_of(0.6, 0.6, 1.5),
              .jerk = place_of(6.0, 6.0, 12.0),
              .nonholonomic = true};
  }

  /// Largest share of the way that goes sideways, over the whole motion; the way that yaw turns goes to `turned`.
  double sideways(const Motion& motion, double* turned = nullptr) const {
    double worst = 0.0;
    JointVector last = motion.q_start;
    constexpr int kSteps = 4000;
    for (int k = 1; k <= kSteps; ++k) {
      const PathSample sample = motion::sample(motion.path, {.s = static_cast<double>(k) / kSteps, .ds = 1.0});
      EXPECT_FALSE(sample.cartesian);
      const JointVector &q = sample.joints.q, &dq = sample.joints.dq;
      if (dq.head<2>().norm() > 1e-9) worst = std::max(worst, std::abs(sideways_speed(q[2], dq)) / dq.head<2>().norm());
      if (turned != nullptr) *turned += std::abs(q[2] - last[2]);
      last = q;
    }
    EXPECT_LT((last - motion.q_goal).norm(), 1e-9);
    return worst;
  }
  Result<Motion> lin(const JointVector& from, const JointVector& to) const {
    return plan_lin(chain, inverse, limits, {}, from, chain.forward(to));
  }

  kinematics::Chain chain = rolling_base();
  kinematics::InverseKinematics inverse;
  JointLimits limits;
};

TEST_F(Rolling, PtpReachesAnyPoseWithoutGoingSideways) {
  Random random(7);
  for (int i = 0; i < 60; ++i) {
    const auto any = [&] { return place_of(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-4, 4)); };
    const JointVector from = any(), to = any();
    const auto motion = plan_ptp(chain, limits, from, to);
    ASSERT_TRUE(motion) << motion.error().to_string();
    EXPECT_EQ(motion->q_goal, to);
    double turned = 0.0;
    EXPECT_LT(sideways(*motion, &turned), 1e-6);
    // It may drive back, so no turn of more than a quarter is needed beside what the goal itself asks for.
    EXPECT_LE(turned, std::abs(to[2] - from[2]) + std::numbers::pi + 1e-6);
  }
}

TEST_F(Rolling, PtpTakesTheNearerOfAheadAndBack) {
  const auto back = plan_ptp(chain, limits, place_of(0, 0, 0), place_of(-2, 0, 0));
  ASSERT_TRUE(back);
  double turned = 0.0;
  EXPECT_LT(sideways(*back, &turned), 1e-9);
  EXPECT_LT(turned, 1e-9) << "straight back needs no turn";
  const auto turn = plan_ptp(chain, limits, place_of(1, 1, 0), place_of(1, 1, 2));
  ASSERT_TRUE(turn);
  const auto alone = plan_ptp(chain,
                              {.lower = limits.lower,
                               .upper = limits.upper,
                               .velocity = limits.velocity,
                               .acceleration = limits.acceleration,
                               .jerk = limits.jerk},
                              place_of(1, 1, 0), place_of(1, 1, 2));
  EXPECT_NEAR(turn->duration(), alone->duration(), 0.05 * alone->duration()) << "a turn alone has no stops";
}

TEST_F(Rolling, LinGoesAlongTheHeadingOrTurnsAndElseIsRefused) {
  EXPECT_TRUE(lin(place_of(0, 0, 0.7), place_of(std::cos(0.7), std::sin(0.7), 0.7)));
  EXPECT_TRUE(lin(place_of(0, 0, 0.7), place_of(-std::cos(0.7), -std::sin(0.7), 0.7)));
  EXPECT_TRUE(lin(place_of(1, 2, 0), place_of(1, 2, 1.5)));
  EXPECT_THAT(lin(place_of(0, 0, 0), place_of(0, 1, 0)), Reports(Code::kUnsupported, "/goal", {"90"}));
  EXPECT_THAT(lin(place_of(0, 0, 0), place_of(1, 0, 1)), Reports(Code::kUnsupported, "/goal"));
  limits.nonholonomic = false;
  EXPECT_TRUE(lin(place_of(0, 0, 0), place_of(0, 1, 0)));
}

TEST_F(Rolling, AnArcWithItsTangentIsFollowed) {
  const CartesianLimits cartesian;
  const ArmModel base{.chain = chain, .inverse = &inverse, .limits = limits, .cartesian = cartesian};
  const auto arc = [&](const Eigen::Vector3d& centre, ArcOrientation orientation) {
    const LegMaker maker = [&base, centre, orientation](const JointVector& q) {
      return circ_leg(
          base, q,
          ArcAbout{.centre = centre, .axis = Eigen::Vector3d::UnitZ(), .angle = 1.2, .orientation = orientation});
    };
    return plan_sequence(base, place_of(0, 0, 0), {maker});
  };
  EXPECT_TRUE(arc({0, 1, 0}, ArcOrientation::kTangential));
  EXPECT_THAT(arc({0, 1, 0}, ArcOrientation::kFixed), Reports(Code::kUnsupported, "/0/goal"));
  EXPECT_THAT(arc({1, 0, 0}, ArcOrientation::kTangential), Reports(Code::kUnsupported, "/0/goal"));
}

/// A line ahead and a turn: what a blend would make of them goes sideways.
TEST_F(Rolling, ABlendBecomesARest) {
  const CartesianLimits cartesian;
  const ArmModel base{.chain = chain, .inverse = &inverse, .limits = limits, .cartesian = cartesian};
  const auto to = [&](const JointVector& goal) {
    return LegMaker([&base, goal](const JointVector& q) {
      auto leg = lin_leg(base, q, base.chain.forward(goal));
      if (leg) leg->blend = {.kind = Blend::Kind::kFraction, .value = 0.3};
      return leg;
    });
  };
  const auto plan = plan_sequence(base, place_of(0, 0, 0), {to(place_of(1, 0, 0)), to(place_of(1, 0, 1.5))});
  ASSERT_TRUE(plan) << plan.error().to_string();
  EXPECT_EQ(plan->notes.list().size(), 1u);
}

}  // namespace
}  // namespace takt::motion::test
