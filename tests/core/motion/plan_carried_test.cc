#include "core/motion/plan_carried.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "core/kinematics/inverse.h"
#include "core/motion/path.h"
#include "tests/core/kinematics/robots.h"
#include "tests/support/limit_oracle.h"
#include "tests/support/reports.h"

namespace takt::motion {
namespace {

using takt::test::Reports;

using kinematics::Chain;
using kinematics::InverseKinematics;

JointVector vector(std::initializer_list<double> values) {
  JointVector v(static_cast<Eigen::Index>(values.size()));
  std::ranges::copy(values, v.begin());
  return v;
}

Chain base_chain() {
  const auto model = kinematics::RobotModel::load("models/youbot_base/youbot_base.urdf");
  EXPECT_TRUE(model);
  const std::vector<std::string> wheels{"front_left", "front_right", "rear_left", "rear_right"};
  return *Chain::create(*model, "odometry", "body", wheels);
}

JointLimits limits_of(const Chain& chain, double acceleration, double jerk) {
  const auto n = chain.joint_count();
  return {.lower = chain.lower(),
          .upper = chain.upper(),
          .velocity = chain.velocity_limit(),
          .acceleration = JointVector::Constant(n, acceleration),
          .jerk = JointVector::Constant(n, jerk)};
}

/// An LWR on a youBot.
struct Bench {
  Chain base = base_chain(), arm = kinematics::test::lwr();
  InverseKinematics base_inverse = *InverseKinematics::create(base), inverse = *InverseKinematics::create(arm);
  JointLimits base_limits = limits_of(base, 0.5, 5.0), limits = limits_of(arm, 5.0, 80.0);
  CartesianLimits cartesian;
  JointVector q_base = vector({0.1, -0.2, 0.3}), q_arm = vector({0.2, -0.5, 0.1, 1.6, 0.0, -0.9, 0.3});

  [[nodiscard]] CarriedArm both() const {
    CarriedArm both{.carrier = {base, &base_inverse, base_limits, cartesian},
                    .rider = {arm, &inverse, limits, cartesian}};
    both.rider.X_FM.translation() << 0.01, 0.0, 0.15;
    both.X_FA.translation() << 0.143, 0.0, 0.1275;
    return both;
  }
  [[nodiscard]] Eigen::Isometry3d tool(const JointVector& at_base, const JointVector& at_arm) const {
    const CarriedArm b = both();
    return base.forward(at_base) * b.X_FA * arm.forward(at_arm) * b.rider.X_FM;
  }
};

Eigen::Isometry3d moved(Eigen::Isometry3d X, const Eigen::Vector3d& by, double turn) {
  X.translation() += by;
  X.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d(0.3, -0.5, 0.8).normalized()) * X.linear();
  return X;
}

TEST(CarriedLine, IsTheLineWhereverTheCarrierIsAndItsDerivativesAreThoseOfItsPoses) {
  Random random(3);
  for (int k = 0; k < 50; ++k) {
    const auto three = [&](double most) {
      return Eigen::Vector3d(random.uniform(-most, most), random.uniform(-most, most), random.uniform(-most, most));
    };
    CarriedLine carried;
    carried.carrier_start = three(1.0);
    carried.carrier_goal = three(2.0);
    carried.X_FA.translation() = three(0.5);
    carried.X_FA.linear() = Eigen::AngleAxisd(0.7, three(1.0).normalized()).toRotationMatrix();
    const Eigen::Isometry3d X = moved(Eigen::Isometry3d::Identity(), three(1.0), 0.4);
    carried.line = CartesianLine::between(X, moved(X, three(1.0), 1.1));
    const auto at = [](double t) {  // any motion of s
      return PathPoint{.s = 0.3 + 0.2 * t + 0.05 * t * t, .ds = 0.2 + 0.1 * t, .dds = 0.1};
    };
    const double s = at(0.0).s;
    const Eigen::Vector3d place = carried.carrier_start + s * (carried.carrier_goal - carried.carrier_start);
    Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
    X_BF.translation() << place.x(), place.y(), 0.0;
    X_BF.linear() = Eigen::AngleAxisd(place.z(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const FrameSample now = carried.sample(at(0.0));
    const Eigen::Isometry3d in_room = X_BF * carried.X_FA * now.X_BM;
    EXPECT_LT((in_room.matrix() - carried.line.sample(at(0.0)).X_BM.matrix()).norm(), 1e-14);

    constexpr double h = 1e-4;
    const FrameSample before = carried.sample(at(-h)), after = carried.sample(at(h));
    const Eigen::Vector3d v = (after.X_BM.translation() - before.X_BM.translation()) / (2 * h);
    const Eigen::Vector3d a =
        (after.X_BM.translation() - 2 * now.X_BM.translation() + before.X_BM.translation()) / (h * h);
    EXPECT_LT((now.V_BM_B.head<3>() - v).norm(), 1e-7);
    EXPECT_LT((now.A_BM_B.head<3>() - a).norm(), 1e-6);
    const Eigen::AngleAxisd turn(after.X_BM.linear() * before.X_BM.linear().transpose());
    EXPECT_LT((now.V_BM_B.tail<3>() - turn.angle() / (2 * h) * turn.axis()).norm(), 1e-6);
    EXPECT_LT((now.A_BM_B.tail<3>() - (after.V_BM_B - before.V_BM_B).tail<3>() / (2 * h)).norm(), 1e-6);
  }
}

TEST(CarriedLine, AsJsonAndBackIsTheSamePath) {
  CarriedLine carried;
  carried.carrier_start = {0.1, 0.2, 0.3};
  carried.carrier_goal = {1, 2, 3};
  carried.X_FA.translation() << 0.1, 0.0, 0.1;
  carried.line =
      CartesianLine::between(Eigen::Isometry3d::Identity(), moved(Eigen::Isometry3d::Identity(), {1, 0, 0}, 0.5),
                             vector({0.1}), vector({0.2}));
  const Path path = CompositePath{{{.geometry = carried}}};
  const auto back = path_from_json(to_json(path));
  ASSERT_TRUE(back) << back.error().to_string();
  const PathPoint at{.s = 0.4, .ds = 1.0, .dds = 0.5};
  EXPECT_LT((sample(*back, at).frame.X_BM.matrix() - sample(path, at).frame.X_BM.matrix()).norm(), 1e-14);
  EXPECT_EQ(sample(*back, at).held.q, sample(path, at).held.q);
  const auto bad = path_from_json(
      {{"kind", "carried_line"}, {"line", {{"kind", "cartesian_arc"}}}, {"mount", {0, 0, 0, 2, 0, 0, 0}}});
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad, Reports(Code::kUnknownName, "/line/kind"));
  EXPECT_THAT(bad, Reports(Code::kMissing, "", {"carrier_start"}));
  EXPECT_THAT(bad, Reports(Code::kMissing, "", {"carrier_goal"}));
  EXPECT_THAT(bad, Reports(Code::kOutOfRange, "/mount"));
}

/// What the net will send: base in proportion, arm by inverse kinematics.
struct Sent {
  std::vector<JointVector> base, arm;
};
Sent follow(const Bench& bench, const PairPlan& plan) {
  Sent sent;
  const CarriedArm both = bench.both();
  const Eigen::Isometry3d X_MF = both.rider.X_FM.inverse();
  JointVector q = plan.follower.q_start;
  const double duration = plan.leader.duration();
  for (int k = 0; k <= static_cast<int>(duration * 1000) + 1; ++k) {
    const LawPoint at = plan.leader.law.at(std::min(duration, k * 1e-3));
    const PathPoint point{.s = at.s, .ds = at.ds, .dds = at.dds};
    const PathSample there = sample(plan.follower.path, point);
    EXPECT_EQ(bench.inverse.solve(there.frame.X_BM * X_MF, there.held.q, q), kinematics::IkStatus::kOk);
    sent.base.push_back(sample(plan.leader.path, point).joints.q);
    sent.arm.push_back(q);
  }
  return sent;
}

void expect_limits(const JointLimits& limits, const std::vector<JointVector>& sent) {
  const auto list = [](const JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
  takt::test::LimitOracle oracle(
      {list(limits.lower), list(limits.upper), list(limits.velocity), list(limits.acceleration), list(limits.jerk)},
      1e-3, 1e-12);
  for (const JointVector& q : sent) oracle.add(list(q));
  EXPECT_LE(oracle.range_excess, 0.0);
  EXPECT_LE(oracle.velocity.share, 1.0 + 1e-6);
  EXPECT_LE(oracle.acceleration.share, 1.0 + 1e-4);
  EXPECT_LE(oracle.jerk.share, 1.0 + 2e-2);
}

TEST(CarriedLin, TheToolGoesStraightInTheRoomWhileTheBaseDrivesAndTurns) {
  const Bench bench;
  const Eigen::Isometry3d X_start = bench.tool(bench.q_base, bench.q_arm);
  const struct {
    JointVector base;
    Eigen::Vector3d by;
    double turn;
  } cases[] = {
      {vector({0.9, -0.2, 0.3}), {0.9, 0.1, 0.05}, 0.0},  // both ahead
      {vector({0.4, 0.3, 0.9}), {0.3, 0.3, -0.1}, 0.4},   // the base turns, the tool turns another way
      {vector({0.1, -0.2, 0.8}), {0.0, 0.0, 0.1}, 0.0},   // the base turns under a tool that goes up
      {vector({-0.1, -0.3, 0.3}), {0.0, 0.0, 0.0}, 0.0},  // the tool stands, the base drives
      {bench.q_base, {0.1, -0.1, 0.1}, 0.2},              // the base stands
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(testing::Message() << "base to " << c.base.transpose() << ", tool by " << c.by.transpose());
    const Eigen::Isometry3d X_goal = moved(X_start, c.by, c.turn);
    const auto plan = plan_carried_lin(bench.both(), bench.q_base, bench.q_arm, c.base, X_goal);
    ASSERT_TRUE(plan) << plan.error().to_string();
    EXPECT_EQ(plan->leader.duration(), plan->follower.duration());
    const Sent sent = follow(bench, *plan);
    const CartesianLine line = CartesianLine::between(X_start, X_goal);
    double off = 0.0, turned = 0.0;
    for (std::size_t k = 0; k < sent.arm.size(); ++k) {
      const LawPoint at = plan->leader.law.at(std::min(plan->leader.duration(), static_cast<double>(k) * 1e-3));
      const Eigen::Isometry3d want = line.sample({.s = at.s}).X_BM, is = bench.tool(sent.base[k], sent.arm[k]);
      off = std::max(off, (want.translation() - is.translation()).norm());
      turned = std::max(turned, Eigen::AngleAxisd(want.linear().transpose() * is.linear()).angle());
    }
    EXPECT_LT(off, 1e-9) << "m off its line in the room";
    EXPECT_LT(turned, 1e-7);
    EXPECT_LT((sent.base.back() - c.base).norm(), 1e-12);
    expect_limits(bench.base_limits, sent.base);
    expect_limits(bench.limits, sent.arm);
  }
}

TEST(CarriedLin, SharesAndSpeedOfTheToolAreKept) {
  const Bench bench;
  const Eigen::Isometry3d X_goal = moved(bench.tool(bench.q_base, bench.q_arm), {0.8, 0.0, 0.0}, 0.0);
  const JointVector goal = vector({0.9, -0.2, 0.3});
  const auto fast = plan_carried_lin(bench.both(), bench.q_base, bench.q_arm, goal, X_goal);
  const auto half = plan_carried_lin(bench.both(), bench.q_base, bench.q_arm, goal, X_goal, {.velocity = 0.5});
  const auto slow = plan_carried_lin(bench.both(), bench.q_base, bench.q_arm, goal, X_goal, {.linear_velocity = 0.1});
  ASSERT_TRUE(fast && half && slow);
  // The base goes 0.8 m, and the tool with it: the speed of both is 0.8 ds.
  const auto fastest = [](const PairPlan& plan) {
    double most = 0.0;
    const double duration = plan.leader.duration();
    for (int k = 0; k <= 1000; ++k) most = std::max(most, 0.8 * plan.leader.law.at(duration * k / 1000).ds);
    return most;
  };
  EXPECT_GT(fast->leader.duration(), 0.8 / 0.4) << "an arm that is only carried needs no time, its base does";
  EXPECT_LT(fast->leader.duration(), 5.0);
  EXPECT_LE(fastest(*fast), 0.4);
  EXPECT_LE(fastest(*half), 0.2);
  EXPECT_GT(fastest(*half), 0.15);
  EXPECT_LE(fastest(*slow), 0.1);
  EXPECT_GT(fastest(*slow), 0.09);
}

TEST(CarriedLin, WhatCannotBeIsAFinding) {
  const Bench bench;
  const Eigen::Isometry3d X = bench.tool(bench.q_base, bench.q_arm);
  const auto text = [&](const JointVector& goal, const Eigen::Isometry3d& X_goal) {
    const auto plan = plan_carried_lin(bench.both(), bench.q_base, bench.q_arm, goal, X_goal);
    return plan ? Diagnostics() : plan.error();
  };
  EXPECT_THAT(text(vector({90, 0, 0}), X), Reports(Code::kOutOfRange, "/carrier/goal/0"));
  EXPECT_THAT(text(vector({3, 0, 0}), X), Reports(Code::kUnreachable, "/goal")) << "it drives away from its tool";
  EXPECT_THAT(text(vector({0.1, 0}), X), Reports(Code::kWrongSize, "/carrier/goal"));
}

}  // namespace
}  // namespace takt::motion
