// Emergency stop, stopping everything, and the real-time clock.
#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "core/device/emergency_stop.h"
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
  EXPECT_EQ(core->state(ptp), NetState::kTerminated);
  EXPECT_EQ(core->status(ptp).cause.code, Cause::Code::kDevice);
  EXPECT_EQ(core->find_arm("left")->phase(), device::Arm::Phase::kBraking);
  steps(2000);
  expect_limits_kept(*left_backend);
}

TEST_F(StopsTest, StopAllEndsEveryNetWithItsCause) {
  const auto left = load_ptp("left"), right = load_ptp("right"), late = load_ptp("left");
  core->post(rcc::Transaction{.abort = {}, .cancel = {}, .start = {left, right}});
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

}  // namespace
}  // namespace takt::test
