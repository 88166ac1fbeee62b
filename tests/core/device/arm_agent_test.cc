// The I/O agent of an arm (rows T2, T3): samples in, set points out, and what it does when they run out.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/device/arm_agent.h"
#include "core/motion/time_law.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/limit_oracle.h"

namespace takt::device {
namespace {

constexpr Nanoseconds kMs = kMillisecond;

JointVector joint(double q) { return JointVector::Constant(1, q); }

motion::JointLimits limits() {
  return {.lower = joint(-3), .upper = joint(3), .velocity = joint(2), .acceleration = joint(10), .jerk = joint(200)};
}

/// 0.5 rad from `begin` on, well inside the limits.
ArmSetPoint set_point(Nanoseconds time, Nanoseconds begin) {
  static const auto law = motion::TimeLaw::rest_to_rest({.velocity = 2.0, .acceleration = 8.0, .jerk = 200.0});
  const auto at = law.at(to_seconds(time - begin));
  return {
      .cycle = time / kMs, .stamp = time, .q = joint(0.5 * at.s), .dq = joint(0.5 * at.ds), .ddq = joint(0.5 * at.dds)};
}

/// A device of 8 ms whose packets take no time, beside a core of 1 ms, on one virtual clock.
class Harness {
 public:
  explicit Harness(const AgentTiming& timing = {.device_cycle = 8 * kMs}) : agent(limits(), timing, clock) {
    packet.sample.q = packet.sample.commanded = joint(0.0);
    packet.sample.dq = joint(0.0);
    packet.sample.ready = true;
  }

  /// One core cycle: what the device does up to now, then the core reads and, if `drive` says so, writes.
  template <class Drive>
  void cycle(const Drive& drive) {
    clock.set(now);
    if (now % agent.timing().device_cycle == 0 && talking) {
      ++packet.sample.sequence;
      packet.instant = now + kOffset;
      packet.sample.stamp = packet.instant;
      if (const auto answer = agent.answer(packet)) answers.push_back(*answer);
    }
    has_sample = agent.read(sample);
    if (has_sample) drive();
    now += kMs;
  }
  void run(Nanoseconds until, Nanoseconds begin) {
    while (now < until) cycle([&] { agent.write(set_point(now, begin)); });
  }
  void idle(Nanoseconds until) {
    while (now < until) cycle([] {});
  }

  static constexpr Nanoseconds kOffset = 77 * kSecond;
  VirtualClock clock;
  ArmAgent agent;
  ArmPacket packet;
  ArmSample sample;
  bool has_sample = false, talking = true;
  Nanoseconds now = 0;
  std::vector<ArmAnswer> answers;
};

/// Differences of what the device was told, at its own instants, against the limits.
test::LimitOracle judge(const std::vector<ArmAnswer>& answers) {
  test::LimitOracle oracle({{-3}, {3}, {2}, {10}, {200}}, 0.008, 1e-13);
  for (const ArmAnswer& answer : answers) oracle.add({answer.state.q[0]});
  return oracle;
}

TEST(ArmAgent, T3_TellsTheDeviceTheMotionWithExactlyTheDeclaredDelay) {
  Harness h;
  h.run(2 * kSecond, 100 * kMs);
  const Nanoseconds delay = h.agent.timing().delay();
  EXPECT_EQ(delay, 17 * kMs) << "a core period and two device cycles";
  double worst = 0.0;
  for (const ArmAnswer& answer : h.answers) {
    const Nanoseconds core_time = answer.instant - Harness::kOffset;
    const double want = set_point(core_time - delay, 100 * kMs).q[0];
    worst = std::max(worst, std::abs(answer.state.q[0] - want));
  }
  EXPECT_LE(worst, 1e-12) << "instants that fall on set points";
  EXPECT_EQ(h.answers.back().state.q[0], 0.5) << "at rest the same bits (row L5)";
  EXPECT_EQ(h.agent.report().reserve_least, 0) << "nothing is delayed more than it must be";
  const auto oracle = judge(h.answers);
  EXPECT_LE(std::max({oracle.velocity.share, oracle.acceleration.share, oracle.jerk.share}), 1.0);
}

TEST(ArmAgent, T3_PaddingIsAddedToTheDelay) {
  Harness h({.device_cycle = 4 * kMs, .margin = kMs / 2, .padding = 9 * kMs});
  h.run(2 * kSecond, 100 * kMs);
  EXPECT_EQ(h.agent.timing().delay(), 8 * kMs + kMs + kMs / 2 + 9 * kMs);
  double worst = 0.0;
  for (const ArmAnswer& answer : h.answers) {
    const Nanoseconds at = answer.instant - Harness::kOffset - h.agent.timing().delay();
    worst = std::max(worst, std::abs(answer.state.q[0] - set_point(at, 100 * kMs).q[0]));
  }
  EXPECT_LE(worst, 200 * 0.5 * 1e-9 / 96 + 1e-12) << "J h^3 / 96: between two set points";
}

TEST(ArmAgent, T2_SamplesCarryTheCoresTimeAndAreHeld) {
  Harness h;
  h.idle(1);
  ASSERT_TRUE(h.has_sample);
  EXPECT_EQ(h.sample.stamp, 0);
  h.idle(100 * kMs);
  EXPECT_EQ(h.sample.stamp, 96 * kMs) << "held since the device's last cycle";
  EXPECT_EQ(h.sample.sequence, 13u);
  h.packet.sample.sequence = 5;  // an old one again
  h.idle(105 * kMs);
  EXPECT_EQ(h.sample.sequence, 13u);
  EXPECT_EQ(h.agent.report().samples.repeated, 0u) << "reported with the next sample that is accepted";
}

TEST(ArmAgent, T3_ADryRingStopsTheArmWithinItsLimits) {
  Harness h;
  h.run(350 * kMs, 100 * kMs);
  ASSERT_GT(std::abs(h.answers.back().state.dq[0]), 0.5) << "in full motion";
  h.idle(1200 * kMs);  // the core reads but says nothing more
  EXPECT_EQ(h.agent.report().dry, 1u);
  EXPECT_EQ(h.answers.back().state.dq[0], 0.0);
  EXPECT_EQ(h.answers.back().state.q[0], h.answers[h.answers.size() - 10].state.q[0]);
  const auto oracle = judge(h.answers);
  EXPECT_LE(oracle.velocity.share, 1.001);
  EXPECT_LE(oracle.acceleration.share, 1.001);
  EXPECT_LE(oracle.jerk.share, 1.001);
}

TEST(ArmAgent, S4_AfterADryRingNothingResumesByItself) {
  Harness h;
  h.run(350 * kMs, 100 * kMs);
  // The core stalls for half a second: neither reads nor writes.
  for (Nanoseconds t = 352 * kMs; t < 850 * kMs; t += 8 * kMs) {
    h.clock.set(t + kMs);
    ++h.packet.sample.sequence;
    h.packet.instant = h.packet.sample.stamp = t + Harness::kOffset;
    if (const auto answer = h.agent.answer(h.packet)) h.answers.push_back(*answer);
  }
  const double stands = h.answers.back().state.q[0];
  h.now = 856 * kMs;
  // It wakes up and goes on as if nothing had been: the old motion, a step away by now.
  int not_ready = 0;
  while (h.now < 1500 * kMs)
    h.cycle([&] {
      if (!h.sample.ready) {
        if (not_ready++ == 0) {
          EXPECT_EQ(h.sample.fault, ArmAgent::kDry);
        }
        return;  // as Arm does
      }
      h.agent.write(set_point(h.now, 100 * kMs));
    });
  EXPECT_GE(not_ready, 1) << "every stop is shown to the core";
  EXPECT_EQ(h.answers.back().state.q[0], stands) << "set points that begin elsewhere do not move it";
  EXPECT_FALSE(ArmAgent::fault_text(ArmAgent::kDry).empty());

  // Set points from where it stands do.
  const JointVector here = h.sample.commanded;
  EXPECT_EQ(here[0], stands);
  const Nanoseconds begin = h.now + 50 * kMs;
  while (h.now < begin + 1500 * kMs)
    h.cycle([&] {
      if (!h.sample.ready) return;
      ArmSetPoint next = set_point(h.now, begin);
      next.q += here;
      h.agent.write(next);
    });
  EXPECT_EQ(h.answers.back().state.q[0], stands + 0.5);
  EXPECT_EQ(h.sample.fault, 0u);
}

TEST(ArmAgent, ADeviceThatWasNotReadyIsTakenUpWhereItSaysItIs) {
  Harness h;
  h.run(350 * kMs, 100 * kMs);
  h.packet.sample.ready = false;
  h.packet.sample.commanded = joint(0.3);
  h.idle(400 * kMs);
  EXPECT_FALSE(h.sample.ready);
  h.packet.sample.ready = true;
  h.packet.sample.commanded = joint(0.31);
  h.idle(500 * kMs);
  EXPECT_TRUE(h.sample.ready);
  EXPECT_EQ(h.sample.commanded[0], 0.31);
  EXPECT_EQ(h.answers.back().state.q[0], 0.31);
}

TEST(ArmAgent, BrakeIsAskedForUntilTheDeviceIsNotReady) {
  Harness h;
  h.run(200 * kMs, 100 * kMs);
  h.agent.brake();
  h.run(230 * kMs, 100 * kMs);
  EXPECT_TRUE(h.answers.back().brake);
  h.packet.sample.ready = false;
  h.idle(260 * kMs);
  EXPECT_FALSE(h.answers.back().brake);
}

/// A better estimate of the clock must not show as a step in velocity.
TEST(ArmAgent, CorrectionsOfTheClockAreSpread) {
  Harness h({.device_cycle = 8 * kMs, .margin = 3 * kMs});
  // The first packets come 2 ms late, so the estimate begins 2 ms wrong and is mended in full motion.
  std::vector<double> speeds;
  while (h.now < 600 * kMs) {
    h.clock.set(h.now);
    const Nanoseconds late = h.now < 300 * kMs ? 2 * kMs : 0;
    if (h.now % (8 * kMs) == late) {
      ++h.packet.sample.sequence;
      h.packet.instant = h.packet.sample.stamp = h.now - late + Harness::kOffset;
      const auto answer = h.agent.answer(h.packet);
      ASSERT_TRUE(answer);
      h.answers.push_back(*answer);
    }
    if (h.agent.read(h.sample)) h.agent.write(set_point(h.now, 100 * kMs));
    h.now += kMs;
  }
  EXPECT_EQ(h.agent.report().dry, 0u);
  const auto oracle = judge(h.answers);
  EXPECT_LE(oracle.velocity.share, 1.001);
  EXPECT_LE(oracle.acceleration.share, 1.0);
}

TEST(ArmAgent, AllocatesNothingOnEitherSide) {
  Harness h;
  h.answers.reserve(1000);
  h.run(100 * kMs, 0);
  const test::AllocationGuard guard;
  h.run(500 * kMs, 0);
  h.idle(1000 * kMs);
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace takt::device
