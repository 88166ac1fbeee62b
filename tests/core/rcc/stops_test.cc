// Emergency stop, stopping everything, and the real-time clock.
#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "core/base/clock.h"
#include "core/device/arm_agent.h"
#include "core/device/emergency_stop.h"
#include "core/motion/path_clock.h"
#include "core/rcc/realtime_clock.h"
#include "tests/core/rcc/fixture.h"

namespace takt::test {
namespace {

using net::Cause;
using rcc::Event;
using rcc::NetState;

class StopsTest : public CoreTest {
 protected:
  rcc::NetId load_ptp(const std::string& arm) { return load(ptp_net(arm, arm, {JointVector::Zero(3), goal})); }
  JointVector goal = joints(0.6, -0.4, 0.2);
};

TEST_F(StopsTest, S4_TheLatchStartsLatchedAndNeedsAnEdgeWhileHealthy) {
  device::EmergencyStop stop("e-stop");
  const auto after = [&stop](bool healthy, bool reset) {
    stop.set_healthy(healthy);
    stop.set_reset(reset);
    stop.begin_cycle(0, 0);
    return stop.latched();
  };
  EXPECT_TRUE(after(true, true));  // stuck button: no edge
  EXPECT_TRUE(after(true, false));
  EXPECT_TRUE(after(false, true));  // an edge, but not healthy
  EXPECT_TRUE(after(true, true));
  EXPECT_TRUE(after(true, false));
  EXPECT_FALSE(after(true, true));
  EXPECT_FALSE(after(true, false));
  EXPECT_TRUE(after(false, false));
  EXPECT_TRUE(after(true, false));  // nothing resumes by itself
}

TEST_F(StopsTest, S4_WhileLatchedNothingStartsAndArmsStop) {
  auto& stop = core->add(std::make_unique<device::EmergencyStop>("e-stop"));
  const auto ptp = load_ptp("left");
  core->start(ptp);
  guarded_step(*core);
  ASSERT_NE(event(Event::Kind::kRefused), nullptr);
  EXPECT_EQ(event(Event::Kind::kRefused)->cause.text.view(), "stopped by e-stop");
  stop.set_healthy(true);
  guarded_step(*core);
  stop.set_reset(true);
  core->start(ptp);
  guarded_step(*core);
  EXPECT_EQ(core->state(ptp), NetState::kRunning);
  steps(300);
  stop.set_healthy(false);
  guarded_step(*core);
  EXPECT_EQ(core->state(ptp), NetState::kCanceling);
  EXPECT_TRUE(run_to_end(ptp, 1000));
  EXPECT_EQ(core->status(ptp).cause.code, Cause::Code::kDevice);
  EXPECT_EQ(core->status(ptp).cause.text.view(), "e-stop");
  EXPECT_TRUE(core->find_arm("left")->at_rest());
  expect_limits_kept(*left_backend);
}

/// Both arms on one clock: left goes to `goal`, right to minus that, so their set points are opposite in every cycle.
class GroupStopTest : public StopsTest {
 protected:
  GroupStopTest() { arm_the_latch(); }

  void arm_the_latch() {
    stop = &core->add(std::make_unique<device::EmergencyStop>("e-stop"));
    stop->set_healthy(true);
    guarded_step(*core);
    stop->set_reset(true);
    guarded_step(*core);
  }

  rcc::NetId start_pair() {
    const JointVector zero = JointVector::Zero(3);
    NetDescription net = ptp_net("pair", "left", {zero, goal});
    net.add("line_2", "JointLine", {{"path", motion::to_json(motion::Path(motion::JointLine{zero, -goal}))}});
    net.add("arm_2", "ArmCommand", {{"device", "right"}});
    for (const char* port : {"s", "ds", "dds"}) net.link(std::string("law.") + port, std::string("line_2.") + port);
    for (const char* port : {"q", "dq", "ddq"}) net.link(std::string("line_2.") + port, std::string("arm_2.") + port);
    const rcc::NetId id = load(net);
    core->start(id);
    steps(300);
    EXPECT_GT(speed(*left_backend), 0.1);
    return id;
  }
  static double speed(const FakeArm& arm) { return arm.sent.back().dq.cwiseAbs().maxCoeff(); }

  device::EmergencyStop* stop;
};

TEST_F(GroupStopTest, S1_AnEmergencyStopBrakesAGroupOnItsPath) {
  for (const auto category : {device::StopCategory::kStopThenBrakes, device::StopCategory::kStopAndHold}) {
    SCOPED_TRACE(static_cast<int>(category));
    stop->set_category(category);
    const rcc::NetId pair = start_pair();
    const double before = left_backend->sent.back().ddq[0];
    stop->set_healthy(false);
    guarded_step(*core);
    EXPECT_LT(left_backend->sent.back().ddq[0], before) << "the first braking set point is that of the same cycle";
    EXPECT_TRUE(run_to_end(pair, 1000));
    EXPECT_EQ(core->status(pair).cause.code, Cause::Code::kDevice);
    steps(10);
    const JointVector left = left_backend->sent.back().q, right = right_backend->sent.back().q;
    EXPECT_LT((left + right).cwiseAbs().maxCoeff(), 1e-15) << "together";
    EXPECT_LT((left / left[0] * goal[0] - goal).cwiseAbs().maxCoeff(), 1e-12) << "on the line";
    EXPECT_LT(left[0], goal[0]);
    for (std::size_t i = 1; i <= 500; ++i) {
      const auto& a = left_backend->sent[left_backend->sent.size() - i].q;
      const auto& b = right_backend->sent[right_backend->sent.size() - i].q;
      ASSERT_LT((a + b).cwiseAbs().maxCoeff(), 1e-15) << i << " cycles before the end";
    }
    const int brakes = category == device::StopCategory::kStopThenBrakes ? 1 : 0;
    EXPECT_EQ(left_backend->brakes, brakes);
    EXPECT_EQ(right_backend->brakes, brakes);
    expect_limits_kept(*left_backend);
    build({});
    arm_the_latch();
  }
}

TEST_F(GroupStopTest, S3_Category0ClosesTheBrakesAtOnce) {
  stop->set_category(device::StopCategory::kBrakes);
  const rcc::NetId pair = start_pair();
  stop->set_healthy(false);
  guarded_step(*core);
  EXPECT_EQ(core->state(pair), NetState::kTerminated);
  EXPECT_EQ(left_backend->brakes, 1);
  EXPECT_EQ(right_backend->brakes, 1);
}

TEST_F(GroupStopTest, S1_AFaultOfOneStopsTheOtherOnItsPath) {
  const rcc::NetId pair = start_pair();
  right_backend->state().ready = false;
  right_backend->state().fault = 3;
  guarded_step(*core);
  EXPECT_EQ(core->state(pair), NetState::kCanceling);
  EXPECT_TRUE(run_to_end(pair, 1000));
  EXPECT_EQ(core->status(pair).cause.text.view(), "right: not ready, fault 3");
  const JointVector left = left_backend->sent.back().q;
  EXPECT_LT((left / left[0] * goal[0] - goal).cwiseAbs().maxCoeff(), 1e-12) << "on the line";
  EXPECT_TRUE(core->find_arm("left")->at_rest());
  expect_limits_kept(*left_backend);
}

TEST_F(GroupStopTest, S1_AFaultDuringAnEmergencyStopAndItsReturnMoveNothing) {
  const rcc::NetId pair = start_pair();
  stop->set_healthy(false);
  steps(20);
  right_backend->state().ready = false;
  steps(5);
  const JointVector right = right_backend->sent.back().q;
  right_backend->state().ready = true;
  EXPECT_TRUE(run_to_end(pair, 1000));
  EXPECT_EQ(right_backend->sent.back().q, right) << "it is taken over where it stands";
  EXPECT_EQ(core->status(pair).cause.text.view(), "e-stop") << "the first cause";
  expect_limits_kept(*left_backend);
}

/// A net whose set points come from no clock cannot be told to stop: its devices are.
TEST_F(GroupStopTest, S2_WhatHasNoPathIsStoppedByTheGuard) {
  NetDescription net;
  net.name = "generator";
  net.add("wish", "ConstantJoints", {{"value", {0.8, 0.0, 0.0}}});
  net.add("generator", "JerkLimitedJointPosition",
          {{"joints", 3},
           {"start", {0.0, 0.0, 0.0}},
           {"velocity_max", {0.5, 0.5, 0.5}},
           {"acceleration_max", {1.0, 1.0, 1.0}},
           {"jerk_max", {10.0, 10.0, 10.0}}});
  net.add("arm", "ArmCommand", {{"device", "left"}});
  net.add("end", "Termination", {{"condition", false}});
  net.link("wish.value", "generator.target");
  net.link("generator.position", "arm.q")
      .link("generator.velocity", "arm.dq")
      .link("generator.acceleration", "arm.ddq");
  const rcc::NetId id = load(net);
  core->start(id);
  steps(300);
  ASSERT_GT(speed(*left_backend), 0.1);
  stop->set_category(device::StopCategory::kStopAndHold);
  stop->set_healthy(false);
  guarded_step(*core);
  EXPECT_EQ(core->state(id), NetState::kTerminated);
  EXPECT_EQ(core->find_arm("left")->phase(), device::Arm::Phase::kBraking);
  steps(2000);
  EXPECT_TRUE(core->find_arm("left")->at_rest());
  expect_limits_kept(*left_backend);
}

TEST_F(StopsTest, StopAllEndsEveryNetWithItsCause) {
  const auto left = load_ptp("left"), right = load_ptp("right"), late = load_ptp("left");
  (void)core->post(rcc::Transaction{.abort = {}, .cancel = {}, .start = {left, right}});
  steps(300);
  core->stop_all(Cause::Code::kOverrun, "too slow");
  core->start(late);
  guarded_step(*core);
  for (const auto net : {left, right}) {
    EXPECT_EQ(core->state(net), NetState::kTerminated);
    EXPECT_EQ(core->status(net).cause.code, Cause::Code::kOverrun);
  }
  EXPECT_EQ(core->state(late), NetState::kReady);
  steps(2000);
  expect_limits_kept(*left_backend);
  expect_limits_kept(*right_backend);
}

/// Real time on another thread, requests from this one: the same states, whatever the machine's mood.
TEST_F(StopsTest, RealtimeClockTakesRequestsFromOutside) {
  left_backend->keep = right_backend->keep = false;
  rcc::RealtimeClock clock({.priority = 0, .lock_memory = false, .overrun_limit = 1'000'000});
  const auto net = core->load_async(ptp_net("ptp", "left", {JointVector::Zero(3), joints(0.02, 0, 0)}));
  std::jthread thread([&](const std::stop_token& stop) { clock.run(*core, stop); });
  while (core->state(net) == NetState::kLoading) std::this_thread::yield();
  EXPECT_NE(core->start(net), 0u);
  while (core->state(net) != NetState::kTerminated) std::this_thread::yield();
  thread.request_stop();
  thread.join();
  EXPECT_EQ(core->status(net).cause.code, Cause::Code::kTerminated);
  EXPECT_GT(core->cycle(), 100);
}

TEST_F(StopsTest, OverrunsBeyondTheLeakStopTheNets) {
  const auto ptp = load_ptp("left");
  core->start(ptp);
  rcc::RealtimeClock clock({.priority = 0, .lock_memory = false, .overrun_limit = 3, .leak_cycles = 1'000'000});
  std::stop_source source;
  int left = 5000;
  clock.run(*core, source.get_token(), [&](rcc::ControlCore& running) {
    if (running.cycle() % 50 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(3));
    if (running.state(ptp) == NetState::kTerminated || --left == 0) source.request_stop();
  });
  EXPECT_EQ(core->status(ptp).cause.code, Cause::Code::kOverrun);
  EXPECT_GE(core->statistics().overruns, 3);
}

/// The clock, the cycle and an agent together: what the clock skips, the agent's time leaves out too. Without that an
/// arm without margin runs dry in every second cycle from the first overrun on: 150 times here. A busy machine may add
/// some.
TEST_F(StopsTest, T3_AnOverrunDoesNotStarveAStandingArm) {
  build({.period = 5 * kMillisecond});
  rcc::RealtimeClock clock({.priority = 0, .lock_memory = false, .overrun_limit = 1'000'000});
  const Nanoseconds cycle = core->period();
  device::ArmAgent agent(description->limits, {.core_period = cycle, .device_cycle = cycle}, clock.time());
  device::ArmPacket packet;
  packet.sample.q = packet.sample.dq = packet.sample.commanded = JointVector::Zero(kFakeJoints);
  packet.sample.ready = true;
  const Nanoseconds begun = MonotonicClock::machine_time();
  std::stop_source source;
  std::int64_t cycles = 0;
  clock.run(*core, source.get_token(), [&](rcc::ControlCore& running) {
    if (++cycles == 50) std::this_thread::sleep_for(std::chrono::milliseconds(37));
    if (cycles == 350) source.request_stop();
    device::ArmSample sample;
    if (agent.read(sample) && sample.ready) {
      const JointVector zero = JointVector::Zero(kFakeJoints);
      agent.write({.cycle = running.cycle(), .stamp = running.time() - cycle, .q = zero, .dq = zero, .ddq = zero});
    }
    // The device sends in each cycle of its own, which goes on while the core is late.
    const auto due = static_cast<std::uint64_t>((MonotonicClock::machine_time() - begun) / cycle);
    while (packet.sample.sequence < due) {
      ++packet.sample.sequence;
      packet.instant = packet.sample.stamp = static_cast<Nanoseconds>(packet.sample.sequence) * cycle;
      (void)agent.answer(packet);
    }
  });
  EXPECT_GE(core->statistics().overruns, 6);
  EXPECT_LT(agent.report().dry, 40u);
}

TEST_F(StopsTest, S4_AStopThatIsOverBeforeTheNextCycleEndsTheNets) {
  auto& stop = core->add(std::make_unique<device::EmergencyStop>("e-stop", 50 * kMillisecond));
  stop.set_healthy(true);
  guarded_step(*core);
  stop.set_reset(true);
  guarded_step(*core);
  stop.set_reset(false);
  const auto ptp = load_ptp("left");
  core->start(ptp);
  for (int i = 0; i < 100; ++i) {
    stop.beat();
    guarded_step(*core);
  }
  ASSERT_EQ(core->state(ptp), NetState::kRunning);
  stop.press(device::StopCategory::kStopAndHold);
  stop.set_healthy(true);
  stop.set_reset(true);
  guarded_step(*core);
  EXPECT_EQ(core->state(ptp), NetState::kCanceling) << "stop and reset in one cycle: the stop counts";
  EXPECT_TRUE(run_to_end(ptp, 1000));
  EXPECT_TRUE(core->find_arm("left")->at_rest());
  EXPECT_TRUE(stop.latched());
}

TEST_F(StopsTest, S4_AnInputWithoutASignOfLifeEndsTheNetsAndSaysSo) {
  auto& stop = core->add(std::make_unique<device::EmergencyStop>("e-stop", 50 * kMillisecond));
  stop.set_healthy(true);
  guarded_step(*core);
  stop.set_reset(true);
  guarded_step(*core);
  const auto ptp = load_ptp("left");
  core->start(ptp);
  steps(60);
  EXPECT_TRUE(run_to_end(ptp, 1000));
  EXPECT_EQ(core->status(ptp).cause.text.view(), "e-stop: its input sends nothing");
  expect_limits_kept(*left_backend);
}

}  // namespace
}  // namespace takt::test
