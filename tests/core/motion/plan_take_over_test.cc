// Motions that go on with one that is running: the seam, the limits under any clock, all kinds into all kinds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/motion/motion_state.h"
#include "core/motion/path_clock.h"
#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/random_paths.h"
#include "tests/support/reports.h"

namespace takt::motion::test {
namespace {

using takt::test::Reports;

namespace robots = kinematics::test;

constexpr double kTakeOverSampleError = 1e-11;  // of q: what inverse kinematics leaves open
constexpr double kLead = 4e-3;                  // s

std::vector<std::string> urdfs() { return {robots::lwr_urdf(), robots::ur5_urdf(), robots::tx90_urdf()}; }

/// A random motion of an arm, and one that takes it over on its way.
struct Relay {
  RandomArm arm;
  Motion before;
  double tau = 0.0;
  std::optional<Motion> after;
  Diagnostics why;
  bool possible = false;  ///< from rest the arm could do it

  Relay(const std::string& urdf, Random& random) : arm(urdf, random), before(first_motion(random)) {
    // Somewhere before the goal, at a whole cycle.
    tau = std::max(1.0, std::floor(random.uniform(0.05, 0.75) * before.duration() / kPeriod)) * kPeriod;
    go_on(random);
  }
  void go_on(Random& random) {
    const Blend blend = random.unit() < 0.5 ? Blend{Blend::Kind::kDistance, random.uniform(0.005, 0.1)}
                                            : Blend{Blend::Kind::kFraction, random.uniform(0.05, 0.5)};
    after.reset();
    const auto maker = random_leg(random, arm, 0.2, blend);
    possible = plan_sequence(arm.model(), before.q_goal, {maker}).has_value();
    auto plan = plan_take_over(arm.model(), {.motion = before, .tau = tau, .lead = kLead, .blend = blend}, {maker});
    if (plan)
      after = std::move(plan->motion);
    else
      why = plan.error();
  }

 private:
  Motion first_motion(Random& random) {
    for (;;) {
      const auto plan = plan_sequence(arm.model(), arm.good_q(random), {random_leg(random, arm, 0.25, {})});
      if (plan && plan->motion.duration() > 0.15) return plan->motion;
    }
  }
};

/// Follows a motion by its clock, as a net does.
class Follower {
 public:
  Follower(const RandomArm& arm, const Motion& motion, PathClock clock, JointVector q)
      : arm_(arm), motion_(motion), clock_(std::move(clock)), q_(std::move(q)) {}

  const JointVector& update(double target) {
    clock_.update(target, kPeriod);
    const PathSample there = sample(motion_.path, follow(motion_.law, clock_.state()));
    if (!there.cartesian) {
      q_ = there.joints.q;
    } else {
      EXPECT_EQ(arm_.inverse.solve(there.frame.X_BM * arm_.X_FM.inverse(), there.held.q, q_),
                kinematics::IkStatus::kOk);
    }
    return q_;
  }
  [[nodiscard]] const PathClock& clock() const { return clock_; }
  [[nodiscard]] const JointVector& q() const { return q_; }

 private:
  const RandomArm& arm_;
  const Motion& motion_;
  PathClock clock_;
  JointVector q_;
};

struct SeenTakeOver {
  takt::test::LimitOracle joints;
  bool taken_over = false;
  JointVector q_end = {};
  double least_rate = 1e300;  ///< of the successor's s, before its last fifth
};

/// Runs the one until the other may take over (in the lead, at a steady rate), then that one.
SeenTakeOver run_relay(const Relay& relay, const Targets& targets) {
  SeenTakeOver seen{joint_oracle(relay.arm.limits, kTakeOverSampleError)};
  const bool in_motion = relay.before.law.begins_in_motion();
  Follower first(relay.arm, relay.before, PathClock(relay.before.clock, relay.before.law, false, in_motion),
                 relay.before.q_start);
  for (int i = 0; i < 3 && !in_motion; ++i) seen.joints.add(as_list(first.q()));
  const auto may_switch = [&] {
    const ClockState& at = first.clock().state();
    return at.rate_change == 0.0 && at.tau >= relay.tau - 1e-9 && at.tau <= relay.tau + kLead;
  };
  for (int cycles = 0; !may_switch(); ++cycles) {
    if (cycles > 30'000 || first.clock().state().tau > relay.tau + kLead) return seen;
    seen.joints.add(as_list(first.update(targets())));
  }
  seen.taken_over = true;
  PathClock clock(relay.after->clock, relay.after->law, false, true);
  const ClockState& at = first.clock().state();
  clock.reset({.tau = at.tau - relay.tau, .rate = at.rate});
  Follower second(relay.arm, *relay.after, clock, first.q());
  for (int cycles = 0; cycles < 30'000 && !second.clock().at_end(); ++cycles) {
    seen.joints.add(as_list(second.update(targets())));
    const double ds = follow(relay.after->law, second.clock().state()).ds;
    if (second.clock().state().tau < 0.8 * relay.after->duration()) seen.least_rate = std::min(seen.least_rate, ds);
  }
  for (int i = 0; i < 3; ++i) seen.joints.add(as_list(second.q()));
  seen.q_end = second.q();
  return seen;
}

void expect_same(const JointSample& a, const JointSample& b, double tolerance) {
  EXPECT_LT((a.q - b.q).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_LT((a.dq - b.dq).cwiseAbs().maxCoeff(), 1e3 * tolerance);
  EXPECT_LT((a.ddq - b.ddq).cwiseAbs().maxCoeff(), 1e5 * tolerance);
}

TEST(PlanTakeOver, P4_TheSuccessorBeginsWhereThePredecessorIsAndLeadsLikeIt) {
  Random random(31);
  int planned = 0;
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(testing::Message() << "relay " << i);
    const Relay relay(urdfs()[static_cast<std::size_t>(i) % 3], random);
    if (!relay.after) continue;
    ++planned;
    EXPECT_TRUE(relay.after->law.begins_in_motion());
    const ArmModel arm = relay.arm.model();
    for (const double later : {0.0, 0.25 * kLead, kLead}) {
      const auto was = joints_at(arm, relay.before, relay.tau + later), is = joints_at(arm, *relay.after, later);
      ASSERT_TRUE(was && is);
      expect_same(*was, *is, 1e-9);
    }
    EXPECT_EQ(joints_at(arm, *relay.after, 1e9)->dq.norm(), 0.0);
  }
  EXPECT_GT(planned, 25);
}

// Rows P1, P3, P4 on every kind into every kind, as planned and under random overrides, pauses and cancels.
TEST(PlanTakeOver, P4_RandomRelaysKeepAllLimitsForAnyTargets) {
  Random random(32);
  int planned = 0, tried = 0, possible = 0, steady = 0, relayed = 0;
  double most = 0.0;
  for (int i = 0; i < 120; ++i) {
    const Relay relay(urdfs()[static_cast<std::size_t>(i) % 3], random);
    ++tried;
    possible += relay.possible;
    if (!relay.after) continue;
    ++planned;
    for (int k = 0; k < 3; ++k) {
      SCOPED_TRACE(testing::Message() << "relay " << i << ", run " << k);
      const SeenTakeOver seen = run_relay(relay, k == 0 ? always(1.0) : at_random(random, false));
      expect_kept(seen.joints, "joints");
      most = std::max({most, seen.joints.acceleration.share, seen.joints.jerk.share});
      relayed += seen.taken_over;
      if (k > 0) continue;
      EXPECT_TRUE(seen.taken_over);
      EXPECT_LT((seen.q_end - relay.after->q_goal).cwiseAbs().maxCoeff(), 1e-8);
      steady += seen.least_rate > 0.0;
    }
  }
  std::printf("%d of %d relays planned (%d possible from rest), %d taken over in %d runs, largest share %.3f\n",
              planned, tried, possible, relayed, 3 * planned, most);
  EXPECT_GT(possible, 80) << "too few to say anything";
  EXPECT_GT(planned, 0.74 * possible);
  EXPECT_EQ(steady, planned) << "it never stops at a blend";
  EXPECT_GT(relayed, planned + planned / 2) << "at any override";
  EXPECT_GT(most, 0.75);
}

TEST(PlanTakeOver, P4_AChainOfTakeOversGoesOnAndOn) {
  Random random(33);
  int links = 0;
  for (int i = 0; i < 18; ++i) {
    Relay relay(urdfs()[static_cast<std::size_t>(i) % 3], random);
    for (int link = 0; link < 6 && relay.after; ++link) {
      SCOPED_TRACE(testing::Message() << "chain " << i << ", link " << link);
      const SeenTakeOver seen = run_relay(relay, always(1.0));
      expect_kept(seen.joints, "joints");
      ++links;
      relay.before = *relay.after;
      relay.tau = std::max(1.0, std::floor(random.uniform(0.1, 0.6) * relay.before.duration() / kPeriod)) * kPeriod;
      // The second motion before: it may be at its own begin, still in motion.
      Relay next = relay;
      next.go_on(random);
      if (next.after) {
        const auto was = joints_at(next.arm.model(), next.before, next.tau);
        expect_same(*was, *joints_at(next.arm.model(), *next.after, 0.0), 1e-9);
      }
      relay.after = next.after;
    }
  }
  EXPECT_GT(links, 15);
}

TEST(PlanTakeOver, WhatCannotBeTakenOverIsSaid) {
  Random random(34);
  const RandomArm arm(robots::ur5_urdf(), random);
  const JointVector q = arm.good_q(random);
  JointVector goal = q, back = q;
  goal[0] += 0.4;
  const auto to = [&](const JointVector& where) -> LegMaker {
    return [&arm, where](const JointVector& from) { return ptp_leg(arm.model(), from, where); };
  };
  const Motion motion = plan_ptp(arm.chain, arm.limits, q, goal).value();
  const auto refusal = [&](double tau, Blend blend, const JointVector& next) {
    const auto plan =
        plan_take_over(arm.model(), {.motion = motion, .tau = tau, .lead = kLead, .blend = blend}, {to(next)});
    return plan ? Diagnostics() : plan.error();
  };
  const Blend some{Blend::Kind::kFraction, 0.3};
  JointVector on = goal;
  on[1] += 0.3;
  EXPECT_EQ(refusal(0.1, some, on).to_string(), "");
  EXPECT_THAT(refusal(0.1, {}, on), Reports(Code::kPlanningFailed, "/blend"));
  EXPECT_THAT(refusal(0.1, {Blend::Kind::kFraction, 0.7}, on), Reports(Code::kOutOfRange, "/blend", {"0.5"}));
  EXPECT_THAT(refusal(0.1, some, back), Reports(Code::kPlanningFailed, "/blend"));
  EXPECT_THAT(refusal(0.1, some, goal), Reports(Code::kPlanningFailed, "/blend"));
  EXPECT_THAT(refusal(motion.duration() - 0.5 * kLead, some, on), Reports(Code::kOutOfRange, "/tau"));
  EXPECT_THAT(refusal(0.0, some, on), Reports(Code::kOutOfRange, "/tau", {"0.0000"})) << "it has not begun";
  EXPECT_FALSE(plan_take_over(arm.model(), {.motion = motion, .tau = 0.1, .blend = some}, {}));
}

}  // namespace
}  // namespace takt::motion::test
