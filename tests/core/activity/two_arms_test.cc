// Two arms as one actuator: one clock, one frame, one net (rows P5, S1).
#include "core/activity/two_arms.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/command/device_sensors.h"
#include "core/device/device_file.h"
#include "tests/support/fake_arm.h"
#include "tests/support/limit_oracle.h"

namespace takt::activity {
namespace {

using testing::HasSubstr;

/// Two LWR 4+ that look at each other, each with a wrist sensor, always where they were sent.
class TwoArmTest : public testing::Test {
 protected:
  TwoArmTest() {
    arm = device::read_arm("models/lwr4plus").value();
    for (const auto& [name, x] : {std::pair("left", 0.0), {"right", 1.2}}) add(name, x);
    const Findings findings = declare_channels(core, cell);
    EXPECT_FALSE(findings.has_errors()) << findings.to_string();
    core.step();
  }

  void add(const std::string& name, double x) {
    backends[name] = std::make_shared<test::FakeArm>(arm->home);
    Eigen::Isometry3d X_WB(Eigen::AngleAxisd(x > 0.0 ? std::numbers::pi : 0.0, Eigen::Vector3d::UnitZ()));
    X_WB.translation() << x, 0.0, 0.4;
    EXPECT_FALSE(cell.frames.add(name, "world", X_WB).has_errors());
    cell.arms[name].device = &core.add(std::make_unique<device::Arm>(name, arm, backends[name], core.period()));
    cell.arms[name].start = arm->home;
    wrists[name] = std::make_shared<test::FakeForceTorqueSensor>();
    cell.sensors[name + " wrist"] = {
        .device = &core.add(std::make_unique<device::ForceTorqueSensor>(
            name + " wrist", std::make_shared<const device::ForceTorqueDescription>(), wrists[name])),
        .arm = name};
  }

  TwoArms pair() {
    const Actuator left(program, "left"), right(program, "right");
    Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
    X_WC.translation() << 0.6, 0.0, (left.frame("world").inverse() * left.flange()).translation().z();
    return {left, right, X_WC};
  }
  /// Steps until the run is over; the largest difference between the two views of C.
  double follow(const TwoArms& both, const RunPtr& run, const std::function<void(int)>& at_cycle = {}) {
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

  std::shared_ptr<const device::ArmDescription> arm;
  std::map<std::string, std::shared_ptr<test::FakeArm>> backends;
  std::map<std::string, std::shared_ptr<test::FakeForceTorqueSensor>> wrists;
  rcc::ControlCore core{{}};
  command::Cell cell;
  Runtime program{core, cell, [this] { core.step(); }};
};

TEST_F(TwoArmTest, P5_BlendedMotionsBeginInOneCycleAndBothSeeTheCentreAtOnePlace) {
  const TwoArms both = pair();
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
  const TwoArms both = pair();
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

TEST_F(TwoArmTest, AForceBetweenThemStopsBoth) {
  const TwoArms both = pair();
  const auto squeezed = is_greater(internal_force(cell, "left wrist", "right wrist"), 20.0);
  const RunPtr run = both.lin_by({0, 0.12, 0}, {.linear_velocity = 0.05, .until = squeezed}).schedule();
  follow(both, run, [&](int cycle) {
    if (cycle != 400) return;
    // Each in its own flange, which look at each other: along the world's x the two push against each other.
    for (const char* name : {"left", "right"}) {
      const Actuator one(program, name);
      const Eigen::Vector3d push_W = (name[0] == 'l' ? 30.0 : -30.0) * Eigen::Vector3d::UnitX();
      const Eigen::Matrix3d R_WF = (one.frame("world").inverse() * one.flange()).linear();
      wrists[name]->sample.wrench.force = R_WF.transpose() * push_W;
    }
  });
  EXPECT_EQ(run->state(), RunState::kCompleted) << run->findings().to_string();
  EXPECT_LT(both.centre().translation().y(), 0.05) << "it went on to the goal";
  EXPECT_GT(both.centre().translation().y(), 0.005);
}

TEST_F(TwoArmTest, AGraspThatIsNoMoreIsRefused) {
  const TwoArms both = pair();
  Actuator(program, "right").use<LinInterface>().lin_by({0, 0, 0.01}).execute();
  const RunPtr run = both.lin_by({0, 0, 0.05}).schedule();
  follow(both, run);
  EXPECT_THAT(run->findings().to_string(), HasSubstr("see the motion centre 10 mm"));
}

}  // namespace
}  // namespace takt::activity
