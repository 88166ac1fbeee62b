// What an arm's agent answers when the clock or the counter of its device lies (rows S2, T2, T3): never a step.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/device/arm_agent.h"

namespace takt::device {
namespace {

constexpr Nanoseconds kMs = kMillisecond;
constexpr double kVelocity = 2.0, kAcceleration = 10.0, kJerk = 200.0;

JointVector joint(double q) { return JointVector::Constant(1, q); }

motion::JointLimits limits() {
  return {.lower = joint(-30),
          .upper = joint(30),
          .velocity = joint(kVelocity),
          .acceleration = joint(kAcceleration),
          .jerk = joint(kJerk)};
}

/// From rest at 0 to `speed` within the limits (jerk phases of 50 ms, 10 rad/s^2), then on at that speed.
ArmSetPoint cruise(Nanoseconds time, Nanoseconds begin, double speed = kVelocity) {
  const double t = std::max(0.0, to_seconds(time - begin)), rise = kAcceleration / kJerk, hold = speed / kAcceleration;
  double q = 0.0, v = 0.0, a = 0.0, left = speed > 0.0 ? t : 0.0;
  const auto piece = [&](double jerk, double most) {
    const double h = std::clamp(left, 0.0, std::max(0.0, most));
    q += h * (v + h * (a / 2 + h * jerk / 6));
    v += h * (a + h * jerk / 2);
    a += h * jerk;
    left -= h;
  };
  piece(kJerk, rise);
  piece(0.0, hold - rise);
  piece(-kJerk, rise);
  if (left > 0.0) {
    q += left * speed;
    v = speed;
    a = 0.0;
  }
  return {.cycle = time / kMs, .stamp = time, .q = joint(q), .dq = joint(v), .ddq = joint(a)};
}

/// A device of 1 ms and the core of 1 ms on one virtual clock. The device goes to what it is answered for its cycle.
class Bench {
 public:
  explicit Bench(Nanoseconds margin = 2 * kMs) : agent(limits(), {.device_cycle = kMs, .margin = margin}, clock) {
    packet.sample.q = packet.sample.commanded = packet.sample.dq = joint(0.0);
    packet.sample.ready = true;
  }
  /// A cycle of both. The core drives on while the arm is ready.
  void cycle() {
    clock.set(now);
    ++packet.sample.sequence;
    device_time += kMs;
    if (talking) send();
    ArmSample sample;
    if (agent.read(sample)) {
      ready = sample.ready;
      fault = sample.fault;
      if (ready && driving) agent.write(cruise(now, 100 * kMs, speed));
    }
    now += kMs;
  }
  void send() {
    packet.instant = packet.sample.stamp = device_time;
    if (const auto answer = agent.answer(packet)) {
      packet.sample.commanded = answer->state.q;  // it goes there
      answers.push_back(*answer);
    }
  }
  /// A cycle that the core does not run in time.
  void cycle_without_core() {
    clock.set(now);
    ++packet.sample.sequence;
    device_time += kMs;
    send();
    now += kMs;
  }
  /// The core leaves them out: its next cycle has the time of the first of them.
  void skip(int cycles) {
    clock.skip(cycles * kMs);
    now -= cycles * kMs;
  }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) cycle();
  }
  /// The largest step between two answers that follow each other, in v_max times a device cycle.
  double largest_step() const {
    double largest = 0.0;
    for (std::size_t i = 1; i < answers.size(); ++i)
      largest = std::max(largest, std::abs(answers[i].state.q[0] - answers[i - 1].state.q[0]) / (kVelocity * 1e-3));
    return largest;
  }

  VirtualClock clock;
  ArmAgent agent;
  ArmPacket packet;
  Nanoseconds now = 0, device_time = 77 * kSecond;
  bool talking = true, driving = true, ready = false;
  double speed = kVelocity;
  std::uint32_t fault = 0;
  std::vector<ArmAnswer> answers;
};

class ClockOfTheDeviceJumps : public testing::TestWithParam<Nanoseconds> {};

/// The counter says which cycle it is; a clock that somebody sets changes nothing.
TEST_P(ClockOfTheDeviceJumps, T3_TheMotionGoesOnWithoutAStep) {
  Bench bench;
  bench.run(600);
  ASSERT_GT(bench.answers.back().state.dq[0], 0.99 * kVelocity);
  bench.device_time += GetParam();
  bench.run(400);
  EXPECT_LE(bench.largest_step(), 1.002);
  EXPECT_TRUE(bench.ready);
  EXPECT_EQ(bench.agent.report().stops, 0u);
  EXPECT_EQ(bench.answers.size(), 1000u);
  EXPECT_NEAR(bench.answers.back().state.dq[0], kVelocity, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Steps, ClockOfTheDeviceJumps,
                         testing::Values(-3600 * kSecond, -100 * kMs, -3 * kMs, -kMs / 2, kMs / 2, 3 * kMs, 100 * kMs,
                                         3600 * kSecond));

/// While the arm brakes by itself, too: the ramp is followed from where it is, not read at its end.
TEST_P(ClockOfTheDeviceJumps, S2_TheBrakingRampIsFollowedFromWhereItIs) {
  Bench bench;
  bench.run(600);
  bench.driving = false;
  bench.run(50);
  ASSERT_EQ(bench.agent.phase(), AgentReport::Phase::kBraking);
  bench.device_time += GetParam();
  bench.run(600);
  EXPECT_LE(bench.largest_step(), 1.002);
  EXPECT_EQ(bench.answers.back().state.dq[0], 0.0);
}

/// A device that begins anew counts from 1 on a clock that begins at 0, and stands where it had stopped.
TEST(AgentSession, S4_ARestartOfCounterAndClockStopsTheArmAndMovesNothing) {
  Bench bench;
  bench.agent.set_held(true);
  bench.run(600);
  const double before = bench.answers.back().state.q[0];
  bench.packet.sample.sequence = 0;
  bench.device_time = 0;
  bench.run(100);
  EXPECT_FALSE(bench.ready);
  EXPECT_EQ(bench.fault, ArmAgent::kRestarted);
  EXPECT_EQ(bench.answers.size(), 600u) << "a net holds the arm: the new session waits, nothing is answered";

  bench.agent.set_held(false);
  bench.driving = false;
  bench.run(100);
  EXPECT_TRUE(bench.ready);
  EXPECT_GT(bench.answers.size(), 690u);
  EXPECT_LE(bench.largest_step(), 1.002);
  EXPECT_EQ(bench.answers.back().state.q[0], before) << "it is taken up where it says that it is";
  EXPECT_EQ(bench.answers.back().session, 1u);
  EXPECT_EQ(bench.agent.report().stops, 1u);
}

TEST(AgentSession, S4_ACoreThatHasNotSeenTheStopGetsNoNewSession) {
  Bench bench;
  bench.run(600);
  bench.packet.sample.sequence = 0;
  bench.device_time = 0;
  for (int i = 0; i < 100; ++i) {  // nobody reads
    bench.now += kMs;
    bench.clock.set(bench.now);
    ++bench.packet.sample.sequence;
    bench.device_time += kMs;
    bench.send();
  }
  EXPECT_EQ(bench.answers.size(), 600u);
}

TEST(AgentSession, S4_ADeviceThatWasSilentIsTakenUpWhereItStands) {
  Bench bench;
  bench.run(600);
  bench.talking = false;
  bench.run(200);
  bench.talking = true;
  bench.driving = false;
  bench.packet.sample.commanded = joint(bench.answers.back().state.q[0] + 0.1);  // where it came to rest by itself
  bench.run(100);
  EXPECT_TRUE(bench.ready);
  EXPECT_EQ(bench.agent.report().lost_sessions, 1u);
  EXPECT_EQ(bench.answers[600].state.dq[0], 0.0) << "no answer continues the old motion";
  EXPECT_EQ(bench.answers[600].state.q[0], bench.answers.back().state.q[0]);
}

/// Set points that step, or that run faster than the arm may: the arm is stopped from where it was told to be.
TEST(AnswerGuard, S2_WhatTheCoreSendsMayNotMakeTheArmStep) {
  for (const int fault : {0, 1, 2}) {
    SCOPED_TRACE(fault);
    Bench bench;
    bench.run(600);
    bench.driving = false;
    bool told = false;
    for (int i = 0; i < 700; ++i) {
      if (!told && bench.ready) {
        ArmSetPoint wrong = cruise(bench.now, 100 * kMs);
        if (fault == 0) wrong.q[0] += 0.05;
        if (fault == 1) wrong.dq[0] = 50.0;
        if (fault == 2) wrong.q[0] = std::nan("");
        bench.agent.write(wrong);
      }
      bench.cycle();
      told = told || !bench.ready;
    }
    EXPECT_LE(bench.largest_step(), 1.003);
    EXPECT_EQ(bench.agent.report().trips, 1u);
    ASSERT_TRUE(bench.agent.report().last_trip);
    EXPECT_EQ(bench.answers.back().state.dq[0], 0.0);
    EXPECT_FALSE(ArmAgent::fault_text(ArmAgent::kStep).empty());
  }
}

/// Row T1: a core that leaves out time goes on later, and its agents with it. One overrun costs one stop at most.
TEST(AgentTime, T3_AfterTheCoreHasSkippedInstantsAStandingArmRunsDryOnceAtMost) {
  Bench bench(0);
  bench.speed = 0.0;
  bench.run(500);
  ASSERT_EQ(bench.agent.phase(), AgentReport::Phase::kFollowing);
  ASSERT_EQ(bench.agent.report().dry, 0u);
  for (int i = 0; i < 5; ++i) bench.cycle_without_core();
  bench.skip(5);
  bench.run(2000);
  EXPECT_LE(bench.agent.report().dry, 1u);
  EXPECT_TRUE(bench.ready);
  EXPECT_EQ(bench.agent.phase(), AgentReport::Phase::kFollowing);
  EXPECT_LE(bench.largest_step(), 0.0);
}

}  // namespace
}  // namespace takt::device
