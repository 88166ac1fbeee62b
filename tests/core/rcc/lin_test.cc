// LIN with the LWR's kinematics on a perfect follower, with and without a force that stops it.
#include <array>

#include <gtest/gtest.h>

#include "core/device/device_file.h"
#include "core/device/force_torque_sensor.h"
#include "core/kinematics/chain.h"
#include "core/motion/path_clock.h"
#include "core/motion/planner.h"
#include "tests/core/rcc/fixture.h"
#include "tests/support/allocation_guard.h"

namespace takt::test {
namespace {

using rcc::NetState;

class LinTest : public testing::Test {
 protected:
  void SetUp() override {
    auto read = device::read_arm("models/lwr4plus");
    ASSERT_TRUE(read) << read.error().to_string();
    arm = *read;
    backend = std::make_shared<FakeArm>(arm->home);
    core.add(std::make_unique<device::Arm>("arm", arm, backend, core.period()));
    sensor = std::make_shared<FakeForceTorqueSensor>();
    core.add(std::make_unique<device::ForceTorqueSensor>(
        "wrist", std::make_shared<const device::ForceTorqueDescription>(), sensor));
    guarded_step(core);
    goal = arm->chain->forward(arm->home);
    goal.translation() += Eigen::Vector3d(0.05, 0.1, -0.15);
    goal.rotate(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
  }

  motion::Motion plan() {
    auto planned = motion::plan_lin(*arm->chain, *arm->inverse, arm->limits, arm->cartesian, arm->home, goal);
    EXPECT_TRUE(planned) << planned.error().to_string();
    return std::move(*planned);
  }

  /// Clock, law, line, inverse kinematics, command; ends at the end of the path or at rest after the stop.
  static NetDescription lin_net(const motion::Motion& motion, double force_limit) {
    NetDescription net;
    net.name = "lin";
    net.add("force", "ForceTorqueSensor", {{"device", "wrist"}});
    net.add("parts", "WrenchComponents").add("norm", "Norm").add("hit", "GreaterThan", {{"b", force_limit}});
    net.add("cancel", "Cancel").add("why", "Or").add("stop", "SetResetLatch", {{"reset", false}});
    net.add("target", "SelectReal", {{"if_true", 0.0}, {"if_false", 1.0}});
    net.add("clock", "PathClock", {{"bounds", motion::to_json(motion.clock)}, {"duration", motion.duration()}});
    net.add("law", "TimeLaw", {{"law", motion::to_json(motion.law)}});
    net.add("line", "CartesianLine", {{"path", motion::to_json(motion.path)}});
    net.add("ik", "InverseKinematics", {{"device", "arm"}});
    net.add("arm", "ArmCommand", {{"device", "arm"}});
    net.add("rested", "And").add("over", "Or").add("end", "Termination");
    net.link("force.wrench", "parts.input").link("parts.force", "norm.input").link("norm.value", "hit.a");
    net.link("hit.value", "why.a").link("cancel.requested", "why.b").link("why.value", "stop.set");
    net.link("stop.value", "target.condition").link("target.value", "clock.target_rate");
    for (const char* port : {"time", "rate", "rate_derivative"})
      net.link(std::string("clock.") + port, std::string("law.") + port);
    for (const char* port : {"s", "ds", "dds"}) net.link(std::string("law.") + port, std::string("line.") + port);
    for (const char* port : {"frame", "twist", "acceleration", "held", "held_velocity", "held_acceleration"})
      net.link(std::string("line.") + port, std::string("ik.") + port);
    for (const char* port : {"q", "dq", "ddq"}) net.link(std::string("ik.") + port, std::string("arm.") + port);
    net.link("stop.value", "rested.a").link("clock.standstill", "rested.b");
    net.link("clock.at_end", "over.a").link("rested.value", "over.b").link("over.value", "end.condition");
    return net;
  }

  rcc::NetId load(const NetDescription& net) {
    auto id = core.load(net);
    if (!id) ADD_FAILURE() << id.error().to_string();
    return id.value_or(0);
  }
  bool run_to_end(rcc::NetId net) {
    for (int i = 0; i < 20'000 && core.state(net) != NetState::kTerminated; ++i) guarded_step(core);
    return core.state(net) == NetState::kTerminated;
  }
  /// Largest distance of the flange from the straight line, m.
  double distance_from_line() const {
    const Eigen::Vector3d from = arm->chain->forward(arm->home).translation();
    const Eigen::Vector3d along = (goal.translation() - from).normalized();
    double worst = 0.0;
    for (const auto& sent : backend->sent) {
      const Eigen::Vector3d p = arm->chain->forward(sent.q).translation() - from;
      worst = std::max(worst, (p - along * along.dot(p)).norm());
    }
    return worst;
  }
  void expect_limits_kept() const {
    const auto list = [](const JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
    const auto& l = arm->limits;
    LimitOracle oracle({list(l.lower), list(l.upper), list(l.velocity), list(l.acceleration), list(l.jerk)}, 1e-3,
                       1e-11);
    for (const auto& sent : backend->sent) oracle.add(list(sent.q));
    EXPECT_LE(oracle.velocity.share, 1.0);
    EXPECT_LE(oracle.acceleration.share, 1.0);
    EXPECT_LE(oracle.jerk.share, 1.0) << "axis " << oracle.jerk.axis << " sample " << oracle.jerk.sample;
  }

  std::shared_ptr<const device::ArmDescription> arm;
  std::shared_ptr<FakeArm> backend;
  std::shared_ptr<FakeForceTorqueSensor> sensor;
  rcc::ControlCore core{{}};
  Eigen::Isometry3d goal;
};

TEST_F(LinTest, P3_StaysOnItsLineAndInsideTheLimits) {
  const auto motion = plan();
  const auto lin = load(lin_net(motion, 5.0));
  core.start(lin);
  ASSERT_TRUE(run_to_end(lin));
  EXPECT_EQ(core.status(lin).cause.code, net::Cause::Code::kTerminated) << core.status(lin).cause.text.view();
  EXPECT_LT(distance_from_line(), 1e-8);
  const auto end = arm->chain->forward(backend->sent.back().q);
  EXPECT_LT((end.translation() - goal.translation()).norm(), 1e-9);
  EXPECT_LT(Eigen::AngleAxisd(end.linear().transpose() * goal.linear()).angle(), 1e-7);
  expect_limits_kept();
}

TEST_F(LinTest, P2_AForceStopsOnThePathFromTheCycleInWhichItIsSeen) {
  const auto lin = load(lin_net(plan(), 5.0));
  core.start(lin);
  const auto* rate = core.net(lin)->find<net::Real>("clock.rate");
  for (int i = 0; i < 300; ++i) guarded_step(core);
  EXPECT_EQ(rate->value, 1.0);
  sensor->sample.wrench.force.z() = 6.0;
  guarded_step(core);
  EXPECT_LT(rate->value, 1.0);  // the same cycle
  ASSERT_TRUE(run_to_end(lin));
  EXPECT_LT(distance_from_line(), 1e-8);
  EXPECT_GT((arm->chain->forward(backend->sent.back().q).translation() - goal.translation()).norm(), 0.01);
  EXPECT_TRUE(core.find_arm("arm")->at_rest());
  expect_limits_kept();
}

TEST_F(LinTest, N3_ADeadForceSensorStopsOnThePathToo) {
  const auto lin = load(lin_net(plan(), 5.0));
  core.start(lin);
  for (int i = 0; i < 300; ++i) guarded_step(core);
  sensor->silent = true;
  ASSERT_TRUE(run_to_end(lin));
  EXPECT_EQ(core.status(lin).cause.code, net::Cause::Code::kTerminated);
  EXPECT_LT(distance_from_line(), 1e-8);
  expect_limits_kept();
}

TEST_F(LinTest, NothingIsAllocatedInTheCycle) {
  backend->keep = false;
  const auto lin = load(lin_net(plan(), 5.0));
  core.start(lin);
  guarded_step(core);
  const AllocationGuard guard;
  while (core.state(lin) != NetState::kTerminated) guarded_step(core);
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace takt::test
