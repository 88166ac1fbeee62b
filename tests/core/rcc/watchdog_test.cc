// A cycle that does not end (row L7): the watchdog, from outside.
#include "core/rcc/watchdog.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

#include <gtest/gtest.h>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/rcc/realtime_clock.h"
#include "tests/core/rcc/fixture.h"

namespace takt::test {
namespace {

using namespace std::chrono_literals;

/// Never returns from its third update; or takes `pause` for each.
class StallsForTest final : public net::Primitive {
 public:
  explicit StallsForTest(net::Setup& setup) : pause_(setup.parameter<net::Real>("pause", 0.0, {.unit = "s"})) {}
  void update(const net::Cycle& cycle) override {
    if (pause_ > 0.0) return std::this_thread::sleep_for(std::chrono::duration<double>(pause_));
    while (cycle.index_in_net >= 2) std::this_thread::sleep_for(1ms);
  }

 private:
  double pause_;
};
TAKT_PRIMITIVE(StallsForTest, "test", "Never returns from its third update.");

/// A device with an agent of its own: when no set point has come for 20 ms it stops the device and says so.
class AgentArm final : public device::ArmBackend {
 public:
  explicit AgentArm(const JointVector& q) : arm_(q), agent_([this](const std::stop_token& stop) { run(stop); }) {}
  bool read(device::ArmSample& sample) override { return arm_.read(sample); }
  void write(const device::ArmSetPoint& set_point) override {
    arm_.write(set_point);
    ++written_;
  }
  void set_payload(const device::PayloadSetting& payload) override { arm_.set_payload(payload); }
  void brake() override {}
  [[nodiscard]] std::string fault_text(std::uint32_t) const override { return {}; }

 private:
  void run(const std::stop_token& stop) {
    for (std::int64_t seen = 0; !stop.stop_requested() && (written_ == 0 || written_ != seen);) {
      seen = written_;
      std::this_thread::sleep_for(20ms);
    }
    if (!stop.stop_requested()) std::fputs("agent: dry, the device stops\n", stderr);
  }

  FakeArm arm_;
  std::atomic<std::int64_t> written_ = 0;
  std::jthread agent_;
};

NetDescription net_with_staller(double pause) {
  NetDescription net;
  net.name = "ill";
  net.add("a_well", "ConstantReal", {{"value", 1.0}}).add("b_sick", "StallsForTest", {{"pause", pause}});
  net.add("c_end", "Termination", {{"condition", false}});
  return net;
}

/// Runs a core in real time with a net that stalls; ends only through the watchdog.
[[noreturn]] void run_until_stuck(bool inside_fragment) {
  const auto description = std::make_shared<const device::ArmDescription>(fake_arm_description(kFakeJoints));
  rcc::ControlCore core({});
  core.add(std::make_unique<device::Arm>("arm", description, std::make_shared<AgentArm>(JointVector::Zero(kFakeJoints)),
                                         core.period()));
  NetDescription net = net_with_staller(0.0);
  if (inside_fragment) {
    net::FragmentDescription part{.id = "part", .net = {}, .inputs = {}, .outputs = {}};
    part.net.add("b_sick", "StallsForTest");
    net.primitives.erase(net.primitives.begin() + 1);
    net.add("on", "ConstantBoolean", {{"value", true}});
    net.fragments.push_back(part);
    net.link("on.value", "part.active");
  }
  core.start(core.load(net).value());
  rcc::RealtimeClock clock(
      {.priority = 0, .lock_memory = false, .watchdog = 500 * kMillisecond, .grace = 200 * kMillisecond});
  clock.run(core, {});
  std::_Exit(0);
}

class WatchdogDeathTest : public testing::Test {
 protected:
  WatchdogDeathTest() { testing::FLAGS_gtest_death_test_style = "threadsafe"; }
};

TEST_F(WatchdogDeathTest, L7_AStalledPrimitiveEndsTheProcessWithItsNameWhenTheDevicesHaveStopped) {
  EXPECT_EXIT(run_until_stuck(false), testing::ExitedWithCode(rcc::Watchdog::kExitStatus),
              "stuck in primitive 'b_sick' of net 1 \\('ill'\\)");
  EXPECT_EXIT(run_until_stuck(false), testing::ExitedWithCode(3), "agent: dry, the device stops");
}

TEST_F(WatchdogDeathTest, L7_InsideAFragmentToo) {
  EXPECT_EXIT(run_until_stuck(true), testing::ExitedWithCode(3), "stuck in primitive 'part/b_sick' of net 1");
}

TEST(Watchdog, L7_SlowCyclesAndIdleCoresAreNotStuck) {
  rcc::ControlCore core({});
  const rcc::Watchdog watchdog(core, {.limit = kSecond});
  core.start(core.load(net_with_staller(0.02)).value());
  for (int k = 0; k < 55; ++k) core.step();  // 1.1 s, each cycle 20 ms late
  std::this_thread::sleep_for(1100ms);       // nobody runs the core
  EXPECT_FALSE(core.running_cycle());
}

TEST(Watchdog, L7_WhatIsRunningIsKnown) {
  rcc::ControlCore core({});
  const auto id = core.load(net_with_staller(0.05)).value();
  core.start(id);
  core.step();
  std::jthread cycle([&core] { core.step(); });
  while (core.where_it_is().net == 0) {
  }
  const rcc::Stall stall = core.where_it_is();
  EXPECT_EQ(stall.cycle, 1);
  EXPECT_EQ(stall.net, id);
  EXPECT_EQ(stall.net_name, "ill");
  std::this_thread::sleep_for(10ms);
  EXPECT_EQ(core.where_it_is().primitive, "b_sick");
}

/// Row T1 and the overrun policy end to end: cycles that are really late, not counted by hand.
TEST(RealtimeClock, AClockThatIsLateTooOftenStopsTheNets) {
  rcc::ControlCore core({});
  const auto id = core.load(net_with_staller(0.004)).value();
  core.start(id);
  rcc::RealtimeClock clock({.priority = 0, .lock_memory = false, .overrun_limit = 5, .leak_cycles = 1000});
  std::stop_source stop;
  std::int64_t cycles = 0;
  clock.run(core, stop.get_token(), [&](rcc::ControlCore& running) {
    if (running.state(id) == rcc::NetState::kTerminated || ++cycles > 500) stop.request_stop();
  });
  ASSERT_EQ(core.state(id), rcc::NetState::kTerminated);
  EXPECT_EQ(core.status(id).cause.code, net::Cause::Code::kOverrun);
  EXPECT_GE(core.statistics().overruns, 5);
  EXPECT_LT(cycles, 50);
}

}  // namespace
}  // namespace takt::test
