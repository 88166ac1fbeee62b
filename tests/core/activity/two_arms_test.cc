// Two arms as one actuator: one clock, one frame, one net (rows P5, S1).
#include "app/interfaces/two_arms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/interfaces/actuator_interfaces.h"
#include "core/activity/composition.h"
#include "core/expression/device_sensors.h"
#include "tests/core/activity/two_arm_cell.h"
#include "tests/support/limit_oracle.h"
#include "tests/support/reports.h"

namespace takt::activity {
namespace {

using takt::test::Reports;

class TwoArmTest : public testing::Test, public test::TwoArmCell {
 protected:
  /// Steps until the run is over; the largest difference between the two views of C.
  double follow(const app::TwoArms& both, const RunPtr& run, const std::function<void(int)>& at_cycle = {}) {
    double apart = 0.0;
    for (int cycle = 0; !run->over() && cycle < 60'000; ++cycle) {
      if (at_cycle) at_cycle(cycle);
      program.step();
      apart = std::max(apart, (both.centre().matrix() - both.centre_by_follower().matrix()).cwiseAbs().maxCoeff());
    }
    return apart;
  }
  double worst_share(const std::string& name) const {
    const auto list = [](const device::JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
    const auto& l = arm->limits;
    test::LimitOracle oracle({list(l.lower), list(l.upper), list(l.velocity), list(l.acceleration), list(l.jerk)}, 1e-3,
                             1e-11);
    for (const auto& sent : backends.at(name)->sent) oracle.add(list(sent.q));
    return std::max({oracle.velocity.share, oracle.acceleration.share, oracle.jerk.share});
  }
  void expect_limits_kept() const {
    for (const char* name : {"left", "right"}) EXPECT_LE(worst_share(name), 1.0) << name;
  }
};

/// Each arm that is left in motion needs two terms of a rule's condition.
TEST(FiveArms, L8_BlendsOfFiveArmsAreLeftInOneCycle) {
  test::TwoArmCell cell({{"a", 0.0}, {"b", 2.0}, {"c", 4.0}, {"d", 6.0}, {"e", 8.0}});
  std::vector<RunPtr> first;
  std::vector<Activity> next;
  for (const auto& [name, arm] : cell.cell.arms) {
    const app::MotionInterface motion = app::Actuator(cell.program, name).use<app::MotionInterface>();
    first.push_back(motion.lin_by({0, 0.1, 0}, {.blend = 0.7}).schedule());
    next.push_back(motion.lin_by({0, 0, -0.1}));
  }
  cell.program.step();
  const RunPtr together = parallel(next).execute();
  EXPECT_TRUE(together->blended());
  for (const RunPtr& one : first) {
    EXPECT_EQ(one->last_cycle() + 1, together->first_cycle()) << one->name();
    EXPECT_EQ(cell.core.status(one->net()).cause.code, net::Cause::Code::kTakenOver) << one->name();
  }
}

TEST_F(TwoArmTest, P5_BlendedMotionsBeginInOneCycleAndBothSeeTheCentreAtOnePlace) {
  const app::TwoArms both = pair();
  const RunPtr first = both.lin_by({0, 0, 0.1}, {.blend = 0.6}).schedule();
  const RunPtr second = both.lin_by({0, 0.1, 0}, {.blend = 0.6}).schedule();
  const RunPtr third = both.lin_by({0, 0, -0.05}).schedule();
  const Eigen::Vector3d from = both.centre().translation();
  EXPECT_LT(follow(both, third), 1e-9);
  require(third);
  EXPECT_TRUE(second->blended());
  EXPECT_TRUE(third->blended());
  EXPECT_EQ(second->first_cycle(), first->last_cycle() + 1);
  EXPECT_LT((both.centre().translation() - from - Eigen::Vector3d(0, 0.1, 0.05)).norm(), 1e-8);
  EXPECT_EQ(backends["left"]->last_written_cycle, backends["right"]->last_written_cycle);
  expect_limits_kept();
}

TEST_F(TwoArmTest, P5_PauseOverrideAndCancelStopBothOnThePath) {
  const app::TwoArms both = pair();
  const RunPtr run = both.lin_by({0, 0.12, 0.05}).schedule();
  EXPECT_LT(follow(both, run,
                   [&](int cycle) {
                     if (cycle == 200) program.pause("left");
                     if (cycle == 900) program.set_speed("left", 0.5);
                     if (cycle == 1'000) run->cancel();
                   }),
            1e-9);
  EXPECT_EQ(run->state(), RunState::kCancelled);
  for (const char* name : {"left", "right"}) EXPECT_TRUE(core.find_arm(name)->at_rest());
  expect_limits_kept();
}

command::CartesianCompliance springs(double stiffness) {
  return {.stiffness = expression::VectorTerm(net::Vector(Eigen::Vector3d::Constant(stiffness)))};
}

TEST_F(TwoArmTest, P5_BothGiveWayAlikeAndBlendWithEqualSprings) {
  const app::TwoArms both = pair();
  for (const char* name : {"left", "right"})
    app::Actuator(program, name).use<app::ControlModeInterface>().switch_to("cartesian_impedance").execute();
  const RunPtr first = both.lin_by({0, 0, 0.1}, {.blend = 0.6, .compliance = springs(700)}).schedule();
  const RunPtr alike = both.lin_by({0, 0.1, 0}, {.blend = 0.6, .compliance = springs(700)}).schedule();
  const RunPtr softer = both.lin_by({0, 0, -0.05}, {.compliance = springs(300)}).schedule();
  EXPECT_LT(follow(both, softer), 1e-9);
  require(softer);
  EXPECT_TRUE(alike->blended());
  EXPECT_FALSE(softer->blended()) << "the rest of the motion before is done with the springs of that one";
  for (const auto& [name, backend] : backends) {
    const auto had = [&](double k) {
      return std::ranges::any_of(backend->given, [&](const auto& one) { return one.stiffness[0] == k; });
    };
    EXPECT_TRUE(had(700)) << name;
    EXPECT_EQ(backend->given.back().stiffness[0], 300) << name;
  }
  expect_limits_kept();
}

TEST_F(TwoArmTest, WhatOneOfThemCannotDoIsRefused) {
  const auto refused = [](const Activity& activity) -> Diagnostics {
    try {
      activity.execute();
    } catch (const ActivityError& error) {
      return error.diagnostics();
    }
    return {};
  };
  const app::TwoArms both = pair();
  EXPECT_THAT(refused(both.lin_by({0, 0, 0.05}, {.compliance = springs(700)})),
              Reports(Code::kNotPossibleNow, "/left+right LIN/compliance", {"right", "cartesian_impedance"}));
  for (const char* name : {"left", "right"})
    app::Actuator(program, name).use<app::ControlModeInterface>().switch_to("cartesian_impedance").execute();
  EXPECT_THAT(refused(both.lin_by({0, 0, 0.05}, {.compliance = springs(6000)})),
              Reports(Code::kOutOfRange, "/left+right LIN/compliance/stiffness_N_m/0", {"right", "6000"}));
  command::CartesianCompliance pushes = springs(700);
  pushes.wrench.emplace(net::Wrench{.force = {0, 0, 5}, .torque = {}});
  EXPECT_THAT(refused(both.lin_by({0, 0, 0.05}, {.compliance = pushes})),
              Reports(Code::kConflict, "/left+right LIN/compliance/wrench"));
  // One of them has no such mode.
  const auto stiff = device::read_arm("models/ur5").value();
  ASSERT_FALSE(cell.frames.add("third", "world", Eigen::Isometry3d(Eigen::Translation3d(1.2, 0, 0.4))).has_errors());
  const auto backend = std::make_shared<test::FakeArm>(stiff->home);
  backend->now = core.time();
  cell.arms["third"].start = stiff->home;
  cell.arms["third"].device = &core.add(std::make_unique<device::Arm>("third", stiff, backend, core.period()));
  core.step();
  core.step();
  const app::TwoArms mixed(app::Actuator(program, "left"), app::Actuator(program, "third"), both.centre());
  EXPECT_THAT(refused(mixed.lin_by({0, 0, 0.01}, {.compliance = springs(700)})),
              Reports(Code::kInvalidValue, "/left+third LIN", {"third", "cartesian_impedance"}));
}

TEST_F(TwoArmTest, AForceBetweenThemStopsBoth) {
  const app::TwoArms both = pair();
  const auto squeezed = is_greater(internal_force(cell, "left wrist", "right wrist"), 20.0);
  const RunPtr run = both.lin_by({0, 0.12, 0}, {.linear_velocity = 0.05, .until = squeezed}).schedule();
  follow(both, run, [&](int cycle) {
    if (cycle != 400) return;
    // Each in its own flange, which look at each other: along the world's x the two push against each other.
    for (const char* name : {"left", "right"}) {
      const app::Actuator one(program, name);
      const Eigen::Vector3d push_W = (name[0] == 'l' ? 30.0 : -30.0) * Eigen::Vector3d::UnitX();
      const Eigen::Matrix3d R_WF = (one.frame("world").inverse() * one.flange()).linear();
      wrists[name]->sample.wrench.force = R_WF.transpose() * push_W;
    }
  });
  EXPECT_EQ(run->state(), RunState::kCompleted) << run->diagnostics().to_string();
  EXPECT_LT(both.centre().translation().y(), 0.05) << "it went on to the goal";
  EXPECT_GT(both.centre().translation().y(), 0.005);
}

/// Its path is one of another frame: it does not go on from a motion of this one.
TEST_F(TwoArmTest, AMotionOfAnotherGraspBeginsAtRest) {
  const app::TwoArms both = pair();
  const app::Actuator left(program, "left"), right(program, "right");
  Eigen::Isometry3d X_WC = both.centre();
  X_WC.translation().x() += 0.1;
  for (const app::TwoArms& other : {app::TwoArms(left, right, X_WC), app::TwoArms(right, left, both.centre())}) {
    const RunPtr first = both.lin_by({0, 0, 0.05}, {.blend = 0.6}).schedule();
    const RunPtr second = other.lin_by({0, 0.02, -0.05}).schedule();
    EXPECT_LT(follow(both, second), 1e-9);
    require(second);
    EXPECT_FALSE(second->blended());
    EXPECT_GT(second->first_cycle(), first->last_cycle());
  }
  expect_limits_kept();
}

TEST_F(TwoArmTest, AGraspThatIsNoMoreIsRefused) {
  const app::TwoArms both = pair();
  app::Actuator(program, "right").use<app::LinInterface>().lin_by({0, 0, 0.01}).execute();
  const RunPtr run = both.lin_by({0, 0, 0.05}).schedule();
  follow(both, run);
  EXPECT_THAT(run->diagnostics(), Reports(Code::kUnknownPosition, "/left+right LIN/grasp", {"10"}));
}

}  // namespace
}  // namespace takt::activity
