// The clock of a device as the master of the core's.
#include "core/rcc/phase_lock.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stop_token>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/clock.h"
#include "core/base/random.h"
#include "core/device/arm_agent.h"
#include "core/rcc/realtime_clock.h"
#include "tests/support/fake_arm.h"

namespace takt::test {
namespace {

constexpr Nanoseconds kPaced = kMillisecond;

/// When the packet of a cycle leaves a device that gains `drift` seconds per second, on the machine's clock.
Nanoseconds packet_of(std::int64_t cycle, double drift) {
  return 123'456 + std::llround(static_cast<double>(cycle * kPaced) / (1.0 + drift));
}

/// How far a time is from the middle between two of these packets.
Nanoseconds off_middle(Nanoseconds due, double drift) {
  const auto device = static_cast<double>(due - packet_of(0, drift)) * (1.0 + drift);
  const double phase = std::fmod(device, kPaced);
  return std::llround(phase - 0.5 * kPaced);
}

/// Runs the core's clock for so many cycles. @return its cycles
std::vector<Nanoseconds> paced(double drift, int cycles) {
  rcc::PhaseLock lock(kPaced);
  std::vector<Nanoseconds> dues;
  Nanoseconds due = 0;
  for (int k = 0; k < cycles; ++k) {
    due += kPaced;
    const Nanoseconds later = lock.correction(due, packet_of(k, drift));
    EXPECT_LE(std::abs(later), 200) << "200 ppm of a period";
    due += later;
    dues.push_back(due);
  }
  return dues;
}

TEST(PhaseLock, CyclesComeToTheMiddleBetweenPacketsAndStay) {
  for (const double drift : {0.0, 80e-6, -150e-6}) {
    const auto dues = paced(drift, 20'000);
    for (std::size_t k = 12'000; k < dues.size(); ++k) ASSERT_LE(std::abs(off_middle(dues[k], drift)), 200) << drift;
  }
}

TEST(PhaseLock, AClockThatIsFurtherOffThanAnyIsNotFollowed) {
  const auto dues = paced(400e-6, 20'000);
  Nanoseconds most = 0;
  for (std::size_t k = 10'000; k < dues.size(); ++k) most = std::max(most, std::abs(off_middle(dues[k], 400e-6)));
  EXPECT_GT(most, 400'000) << "the packets pass by";
}

TEST(PhaseLock, ADeviceThatIsSilentLeavesTheClockAsItIs) {
  rcc::PhaseLock lock(kPaced);
  EXPECT_EQ(lock.correction(10 * kPaced, std::nullopt), 0);
  EXPECT_EQ(lock.off().count(), 0);
  EXPECT_EQ(lock.correction(10 * kPaced, 0), 200) << "late by half a period: on the way there";
  EXPECT_EQ(lock.off().count(), 0) << "not there yet";
  EXPECT_EQ(lock.correction(10 * kPaced + 499'000, 0), 200);
  EXPECT_EQ(lock.correction(10 * kPaced + 500'050, 0), -50) << "packets of any cycle, before and behind";
  EXPECT_EQ(lock.correction(10 * kPaced - 499'950, 30 * kPaced), -50);
  EXPECT_EQ(lock.off().count(), 3);
  EXPECT_EQ(lock.off().worst(), 1000);
}

/// A core, an arm whose clock gains on it, and a wire between them that jitters.
class PacedArm {
 public:
  static constexpr double kDrift = 80e-6;

  explicit PacedArm(bool locked) : locked_(locked) {}

  /// @return for each of the last cycles of the device how far the instant that its set point is read at is from where
  /// that of the first of them was, without the wire's delay, ns
  std::vector<Nanoseconds> run(int cycles) {
    std::vector<Nanoseconds> read_at;
    for (std::int64_t n = 0; n < cycles; ++n) {
      const Nanoseconds arrival = packet_of(n, kDrift) + 100'000 + static_cast<Nanoseconds>(random_.unit() * 200'000);
      while (due_ <= arrival) step();
      answer(n, arrival);
      if (n >= cycles / 2) read_at.push_back(agent.resampled_time() - n * kPaced);
    }
    return read_at;
  }

  device::ArmAgent agent{fake_arm_description(1).limits, {.margin = 500'000}, clock_};

 private:
  void at(Nanoseconds machine) { clock_.set(machine - clock_.read().skipped); }
  void step() {
    at(due_);
    device::ArmSample sample;
    if (agent.read(sample) && sample.ready) {
      if (begin_ < 0) begin_ = cycle_;
      const double t = to_seconds((cycle_ - begin_) * kPaced), amplitude = 0.2;
      const auto one = [](double value) { return device::JointVector::Constant(1, value); };
      agent.write({.cycle = cycle_,
                   .stamp = cycle_ * kPaced,
                   .q = one(amplitude * (1.0 - std::cos(t))),
                   .dq = one(amplitude * std::sin(t)),
                   .ddq = one(amplitude * std::cos(t))});
    }
    ++cycle_;
    due_ += kPaced;
    if (!locked_) return;
    const Nanoseconds later = lock_.correction(due_, agent.report().packet_time);
    due_ += later;
    clock_.skip(later);
  }
  void answer(std::int64_t n, Nanoseconds arrival) {
    at(arrival);
    device::ArmPacket packet;
    packet.sample.sequence = static_cast<std::uint64_t>(n) + 1;
    packet.instant = packet.sample.stamp = (n + 1) * kPaced;
    packet.sample.q = packet.sample.commanded = told_;
    packet.sample.dq = device::JointVector::Zero(1);
    packet.sample.ready = true;
    if (const auto answer = agent.answer(packet)) told_ = answer->state.q;
  }

  VirtualClock clock_;
  rcc::PhaseLock lock_{kPaced};
  Random random_{7};
  bool locked_;
  Nanoseconds due_ = 0;
  std::int64_t cycle_ = 0, begin_ = -1;
  device::JointVector told_ = device::JointVector::Zero(1);
};

Nanoseconds spread(const std::vector<Nanoseconds>& values) {
  const auto [least, most] = std::ranges::minmax(values);
  return most - least;
}

TEST(PhaseLock, SetPointsAreReadAtOnePhaseOfTheirCyclesWhileAnArmMoves) {
  PacedArm locked(true), free(false);
  EXPECT_LT(spread(locked.run(30'000)), 60'000) << "what the estimate of the clock is off by";
  EXPECT_GT(spread(free.run(30'000)), kPaced) << "80 ppm in 15 s: each phase there is";
  for (const PacedArm* one : {&locked, &free}) {
    EXPECT_EQ(one->agent.phase(), device::AgentReport::Phase::kFollowing);
    EXPECT_EQ(one->agent.report().stops, 0u) << "neither ran dry nor stepped";
  }
}

TEST(RealtimeClock, CyclesBeginAsThePaceSaysAndTheCoresTimeWithThem) {
  rcc::ControlCore core({});
  MonotonicClock time;
  int asked = 0;
  rcc::RealtimeClock clock(
      {.priority = 0, .lock_memory = false, .watchdog = 0, .time = &time, .pace = [&](Nanoseconds due) {
         // The core's time is that of the cycle that is due, as it was planned.
         EXPECT_EQ(due - time.read().skipped, core.time());
         ++asked;
         return Nanoseconds{asked % 2 == 0 ? 100'000 : -40'000};
       }});
  std::stop_source stop;
  const Nanoseconds begin = MonotonicClock::machine_time();
  clock.run(core, stop.get_token(), [&](rcc::ControlCore& running) {
    if (running.cycle() == 100) stop.request_stop();
  });
  EXPECT_EQ(asked, 100);
  EXPECT_GE(MonotonicClock::machine_time() - begin, 100 * kPaced + 50 * 60'000);
}

}  // namespace
}  // namespace takt::test
