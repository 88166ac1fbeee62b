// Sequences of motions of all kinds: blends, rests, and the limits of all of it under any clock.
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/motion/blend_limits.h"
#include "core/motion/plan_checks.h"
#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/random_paths.h"
#include "tests/support/reports.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

namespace robots = kinematics::test;

// Inverse kinematics ends with a residual below 1e-12; at the singularity measures met here that is less in q than:
constexpr double kSequenceSampleError = 1e-11;

/// Runs a plan and judges joints, and the frame where it is Cartesian.
struct Watched {
  takt::test::LimitOracle joints;
  double largest_step = 0.0;
  double least_rate = 1e300;  ///< of s, between the first and the last tenth
  double rest_between = 0.0;
  JointVector q_end = {};
};

Watched watch(const RandomArm& arm, const Motion& motion, const Targets& targets) {
  Watched seen{joint_oracle(arm.limits, kSequenceSampleError)};
  JointVector q = motion.q_start;
  run(motion, targets, 30000, [&](const PathPoint& at) {
    const PathSample there = sample(motion.path, at);
    const JointVector last = q;
    if (there.cartesian) {
      ASSERT_EQ(arm.inverse.solve(there.frame.X_BM * arm.X_FM.inverse(), there.held.q, q), kinematics::IkStatus::kOk);
    } else {
      q = there.joints.q;
    }
    seen.joints.add(as_list(q));
    seen.largest_step = std::max(seen.largest_step, (q - last).cwiseAbs().maxCoeff());
    if (at.s > 0.1 && at.s < 0.9) seen.least_rate = std::min(seen.least_rate, at.ds);
  });
  seen.q_end = q;
  return seen;
}

// A circle whose only limit is the length a of its acceleration has a closed form: with w = v / sqrt(a r), speeding up
// takes sqrt(r / a) times the integral of 1 / sqrt(1 - w^4) from 0 to 1, and 45 degrees; so does slowing down.
TEST(PlanSequence, ACircleTakesTheTimeOfTheClosedForm) {
  constexpr double kLemniscate = 1.3110287771460600;  // that integral
  Random random(52);
  int planned = 0;
  for (int i = 0; i < 24; ++i) {
    SCOPED_TRACE(testing::Message() << "circle " << i);
    const std::vector<std::string> urdfs = {robots::lwr_urdf(), robots::ur5_urdf(), robots::tx90_urdf()};
    RandomArm arm(urdfs[static_cast<std::size_t>(i) % 3], random);
    arm.limits.velocity *= 1e3;
    arm.limits.acceleration *= 1e4;
    arm.limits.jerk *= 1e6;
    const double a = random.uniform(1.0, 5.0), radius = random.uniform(0.02, 0.1), angle = random.uniform(1.7, 5.0);
    arm.cartesian = {1e3, a, 1e5, 1e3, 1e5, 1e10};
    const JointVector q = arm.good_q(random);
    const Eigen::Vector3d out = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const ArcAbout about{.centre = (arm.chain.forward(q) * arm.X_FM).translation() + radius * out,
                         .axis = out.unitOrthogonal(),
                         .angle = angle};
    const auto circle = [&](const JointVector& from) { return circ_leg(arm.model(), from, about); };
    const auto plan = plan_sequence(arm.model(), q, {circle});
    if (!plan) continue;  // out of reach
    ++planned;
    const double shortest =
        std::sqrt(radius / (kLawShareOfAcceleration * a)) * (2.0 * kLemniscate + angle - 0.5 * std::numbers::pi);
    EXPECT_GT(plan->motion.duration(), shortest);
    EXPECT_LT(plan->motion.duration(), 1.01 * shortest);
  }
  EXPECT_GT(planned, 12);
}

// Rows P1, P3 on everything that can be joined.
TEST(PlanSequence, P3_RandomBlendedSequencesKeepJointLimitsForAnyTargets) {
  Random random(71);
  const std::vector<std::string> urdfs = {robots::lwr_urdf(), robots::ur5_urdf(), robots::tx90_urdf()};
  int planned = 0;
  int blended = 0;
  double most = 0.0;
  for (int i = 0; i < 90; ++i) {
    const RandomArm arm(urdfs[static_cast<std::size_t>(i) % urdfs.size()], random);
    const JointVector q0 = arm.good_q(random);
    std::vector<LegMaker> makers;
    const auto count = 1 + random.bits() % 4;
    for (std::size_t k = 0; k < count; ++k) {
      const Blend blend = random.unit() < 0.5 ? Blend{Blend::Kind::kDistance, random.uniform(0.005, 0.1)}
                                              : Blend{Blend::Kind::kFraction, random.uniform(0.05, 0.5)};
      makers.push_back(random_leg(random, arm, 0.2, blend));
    }
    const auto plan = plan_sequence(arm.model(), q0, makers);
    if (!plan) continue;
    ++planned;
    blended += count > 1 && plan->notes.empty();
    for (int k = 0; k < 3; ++k) {
      SCOPED_TRACE(testing::Message() << "sequence " << i << ", run " << k);
      const auto targets = k == 0 ? always(1.0) : at_random(random, k == 1);
      const Watched seen = watch(arm, plan->motion, targets);
      expect_kept(seen.joints, "joints");
      EXPECT_LT(seen.largest_step, arm.limits.velocity.maxCoeff() * kPeriod) << "another branch";
      most = std::max({most, seen.joints.acceleration.share, seen.joints.jerk.share});
      if (k > 0) continue;
      EXPECT_LT((seen.q_end - plan->motion.q_goal).cwiseAbs().maxCoeff(), 1e-8);
      if (plan->notes.empty()) {
        EXPECT_GT(seen.least_rate, 0.0) << "never stops at a blend";
      }
      EXPECT_EQ(plan->handed_over.size(), count - 1);
      EXPECT_TRUE(std::ranges::is_sorted(plan->handed_over));
    }
  }
  EXPECT_GT(planned, 40) << "too few to say anything";
  EXPECT_GT(blended, 15);
  EXPECT_GT(most, 0.75);
}

// A corner is passed the more slowly the sharper it is: a blend of a tenth of a millimetre took eight times as long as
// the same two motions with a stop, one of a nanometre hours.
TEST(PlanSequence, ASmallBlendNeverTakesLongerThanAStop) {
  Random random(77);
  const RandomArm arm(robots::lwr_urdf(), random);
  int compared = 0, stopped = 0;
  for (int i = 0; i < 20; ++i) {
    const JointVector q0 = arm.good_q(random);
    Random same = random;
    const auto plan_with = [&](const Blend& blend) {
      random = same;
      const auto first = random_leg(random, arm, 0.2, blend);
      return plan_sequence(arm.model(), q0, {first, random_leg(random, arm, 0.2, {})});
    };
    const auto rest = plan_with({});
    if (!rest) continue;
    for (const double m : {kLeastBlend_m, 1e-4, 1e-3}) {
      const auto plan = plan_with({Blend::Kind::kDistance, m});
      if (!plan) continue;
      ++compared;
      stopped += !plan->notes.empty();
      EXPECT_LT(plan->motion.duration(), 1.001 * rest->motion.duration())
          << "sequence " << i << ", blend " << m << " m";
    }
  }
  EXPECT_GT(compared, 12);
  EXPECT_GT(stopped, 4);
}

TEST(PlanSequence, ABlendThatIsTooSmallIsRefused) {
  Random random(78);
  const RandomArm arm(robots::lwr_urdf(), random);
  const JointVector q0 = arm.good_q(random), q1 = arm.good_q(random);
  for (const auto& [blend, names] : std::initializer_list<std::pair<Blend, std::vector<std::string>>>{
           {Blend{Blend::Kind::kDistance, 1e-9}, {"1e-09", "1e-05"}},
           {Blend{Blend::Kind::kDistance, 1e-300}, {"1e-300", "1e-05"}},
           {Blend{Blend::Kind::kFraction, 1e-9}, {"1e-09", "0.0001", "0.5"}},
           {Blend{Blend::Kind::kFraction, 0.6}, {"0.6", "0.0001", "0.5"}}}) {
    const auto to = [&](const JointVector& goal) {
      return [&, goal](const JointVector& q) {
        auto leg = ptp_leg(arm.model(), q, goal);
        if (leg) leg->blend = blend;
        return leg;
      };
    };
    const auto plan = plan_sequence(arm.model(), q0, {to(q1), to(q0)});
    ASSERT_FALSE(plan.has_value());
    EXPECT_THAT(plan.error(), Reports(Code::kOutOfRange, "/0/blend", names));
  }
}

}  // namespace
}  // namespace takt::motion::test
