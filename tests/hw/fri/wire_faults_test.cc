// What the wire, the controller and the driver may do, in virtual time: losses, strangers, restarts, deaths.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "tests/hw/fri/twin_bench.h"
#include "tests/support/limit_oracle.h"

namespace takt::test {
namespace {

using device::JointVector;
using hw::Endpoint;
using hw::fri::State;
using hw::fri::TwinOptions;
using Phase = device::Arm::Phase;

TwinOptions lossy(double loss) {
  TwinOptions options;
  options.drift = 80e-6;
  options.client.margin = 300'000;
  options.faults.wire = {.transport = 100'000, .jitter = 200'000, .loss = loss};
  return options;
}

/// Largest shares of the limits that the drives were told since `from`.
LimitOracle oracle_of(const FriBench& bench, std::size_t from) {
  const auto list = [](const JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
  const auto& l = bench.arm.description().limits;
  LimitOracle oracle({list(l.lower), list(l.upper), list(l.velocity), list(l.acceleration), list(l.jerk)}, 1e-3, 1e-12);
  for (std::size_t i = from; i < bench.rig.tap->told.size(); ++i) oracle.add(list(bench.rig.tap->told[i].q));
  return oracle;
}

/// The gate takes minutes of virtual time; TAKT_LOSS_MINUTES=60 makes it the hour of docs/hardware.md.
int loss_minutes() {
  const char* text = std::getenv("TAKT_LOSS_MINUTES");
  return text != nullptr ? std::max(1, std::atoi(text)) : 3;
}

TEST(FriWire, FivePercentLossBothWaysStopsNothing) {
  FriBench bench(lossy(0.05));
  bench.keep_told = false;
  ASSERT_TRUE(bench.becomes_ready());
  (void)bench.twin().news();
  bench.start();
  const std::int64_t cycles = loss_minutes() * 60'000;
  for (const std::int64_t end = bench.k + cycles; bench.k < end && bench.nets_ended == 0;) bench.cycle();
  EXPECT_EQ(bench.nets_ended, 0) << "at " << bench.k << " ms: " << testing::PrintToString(bench.twin().news());
  EXPECT_EQ(bench.controller().fallbacks(), 0u);
  const double misses = bench.report().statistics.misses / static_cast<double>(cycles);
  EXPECT_NEAR(misses, 1.0 - 0.95 * 0.95, 0.006) << "the losses were there";
  EXPECT_EQ(bench.report().agent.trips, 0u);
}

/// Lost answers in the middle of a swing.
struct Burst {
  bool stopped = false;
  std::int64_t stop_after = 0;  // cycles of the controller from the first missing answer to the stop
  double acceleration = 0.0;    // share of the limit that the drives were told
  bool monotonic = true;
};
Burst burst(int count) {
  FriBench bench;
  EXPECT_TRUE(bench.becomes_ready());
  bench.start(1.0);
  bench.cycles(300);
  const std::size_t from = bench.rig.tap->told.size();
  const std::uint64_t falls = bench.controller().fallbacks();
  bench.twin().wire().lose_next(50'000, count);  // the first port that the network gives: the controller's
  Burst result;
  for (int i = 0; i < 60 && bench.controller().fallbacks() == falls; ++i) {
    bench.cycle();
    ++result.stop_after;
  }
  result.stopped = bench.controller().fallbacks() > falls;
  bench.cycles(result.stopped ? 400 : 100);
  result.acceleration = oracle_of(bench, from).acceleration.share;
  for (std::size_t i = from; i + 1 < bench.rig.tap->told.size(); ++i)
    if (bench.rig.tap->told[i + 1].q[0] < bench.rig.tap->told[i].q[0] - 1e-6) result.monotonic = false;
  EXPECT_EQ(bench.nets_ended, result.stopped ? 1 : 0) << count;
  return result;
}

TEST(FriWire, TheArmStopsAtTheTwentiethMissingAnswerAndAtNoOther) {
  for (int count = 1; count <= 40; ++count) {
    const Burst lost = burst(count);
    EXPECT_EQ(lost.stopped, count >= 20) << count;
    // The answer that is lost first is missing one cycle after it was sent.
    if (lost.stopped) {
      EXPECT_EQ(lost.stop_after, 21) << count;
    }
    EXPECT_LE(lost.acceleration, count >= 20 ? 1.1 : 2.0) << count;
    EXPECT_TRUE(lost.monotonic) << count;
  }
}

TEST(FriWire, ReorderedAndRepeatedDatagramsAndWrappingCountersMakeNoStepBackwards) {
  TwinOptions options;
  options.drift = -80e-6;
  options.client.margin = 300'000;
  options.controller.first_sequence = 65'000;
  options.faults.wire = {.transport = 50'000, .jitter = 300'000, .repeat = 0.2, .reorder = 0.1, .hold_back = 2'500'000};
  FriBench bench(options);
  ASSERT_TRUE(bench.becomes_ready());
  bench.start(2.0);  // 2.5 s in one direction, over the wrap of both counters
  const std::size_t from = bench.rig.tap->told.size();
  bench.cycles(1200);
  const auto& told = bench.rig.tap->told;
  EXPECT_EQ(bench.nets_ended, 0) << bench.arm.fault_text();
  EXPECT_GT(bench.report().old, 100u);
  for (std::size_t i = from; i + 1 < told.size(); ++i)
    for (int joint = 0; joint < hw::fri::kJoints; ++joint)
      ASSERT_GE(told[i + 1].q[joint], told[i].q[joint] - 1e-6) << i - from << " cycles after the start";
  EXPECT_GT(told.back().q[0], 0.5);
}

TEST(FriWire, CorruptAndTruncatedDatagramsAreCountedOrBridged) {
  TwinOptions options = lossy(0.0);
  options.faults.truncate = 0.05;
  FriBench bench(options);
  ASSERT_TRUE(bench.becomes_ready());
  bench.start();
  bench.cycles(20'000);
  EXPECT_EQ(bench.nets_ended, 0);
  EXPECT_GT(bench.report().misread, 500u);
  EXPECT_GT(bench.twin().emulator().counts().misread, 500u);
}

/// Bits flip although a network's check sum should have caught it: what is implausible stops the arm within its limits.
TEST(FriWire, FlippedBitsNeverMoveTheArmBeyondItsLimits) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    TwinOptions options = lossy(0.0);
    FriBench bench(options, seed);
    ASSERT_TRUE(bench.becomes_ready());
    options.faults.corrupt = 0.02;
    bench.twin().wire().set_faults(options.faults);
    const std::size_t from = bench.rig.tap->told.size();
    for (int i = 0; i < 10'000; ++i) {
      bench.cycle();
      if (bench.arm.phase() == Phase::kFrozen && !bench.arm.refusal()) bench.start(bench.told()[0] > 0.0 ? -0.3 : 0.3);
      if (bench.controller().state() == State::kMonitor) bench.twin().reset();
    }
    const LimitOracle oracle = oracle_of(bench, from);
    EXPECT_LE(oracle.range_excess, 0.0);
    EXPECT_LE(oracle.velocity.share, 1.1);
    EXPECT_LE(oracle.acceleration.share, 7.7) << "76.8 rad/s^2 are let pass at the wrist, the model has 10";
  }
}

TEST(FriWire, AfterARestartOfTheControllerNothingMovesWithoutAReset) {
  FriBench bench;
  ASSERT_TRUE(bench.becomes_ready());
  bench.start();
  bench.cycles(150);
  bench.twin().restart_controller();
  bench.cycles(300);
  EXPECT_EQ(bench.nets_ended, 1);
  const JointVector stands = bench.told();
  bench.cycles(5000);
  EXPECT_EQ(bench.arm.phase(), Phase::kNotReady);
  EXPECT_EQ(bench.controller().state(), State::kMonitor) << "nobody asked for more";
  EXPECT_EQ(bench.told(), stands);
  bench.twin().reset();
  ASSERT_TRUE(bench.becomes_ready()) << bench.arm.fault_text();
  EXPECT_NEAR((bench.told() - stands).cwiseAbs().maxCoeff(), 0.0, 1e-6);
  bench.start();
  bench.cycles(500);
  EXPECT_EQ(bench.nets_ended, 1);
}

TEST(FriWire, AKilledDriverStopsTheArmWithinItsLimits) {
  FriBench bench;
  ASSERT_TRUE(bench.becomes_ready());
  bench.start(1.0);
  bench.cycles(300);
  const std::size_t from = bench.rig.tap->told.size();
  int until_stop = 0;
  while (bench.controller().state() == State::kCommand && until_stop < 100) {
    bench.twin().pass_cycle_without_driver();
    ++until_stop;
  }
  EXPECT_NEAR(until_stop, 20, 1);
  for (int i = 0; i < 2000; ++i) bench.twin().pass_cycle_without_driver();
  EXPECT_LE(oracle_of(bench, from).acceleration.share, 1.1);
  EXPECT_EQ(bench.rig.tap->told.back().dq, JointVector::Zero(7));
  EXPECT_EQ(bench.controller().state(), State::kMonitor);
  EXPECT_EQ(bench.controller().quality(), hw::fri::Quality::kUnacceptable);
}

TEST(FriWire, ACutCableEndsTheNetAndNothingResumesWhenItIsPluggedIn) {
  FriBench bench;
  ASSERT_TRUE(bench.becomes_ready());
  bench.start();
  bench.cycles(200);
  bench.twin().wire().set_cut(true);
  bench.cycles(500);
  EXPECT_EQ(bench.nets_ended, 1);
  EXPECT_FALSE(bench.arm.fault_text().empty());
  const JointVector stands = bench.told();
  bench.twin().wire().set_cut(false);
  bench.cycles(3000);
  EXPECT_EQ(bench.told(), stands);
  EXPECT_EQ(bench.arm.phase(), Phase::kNotReady);
  EXPECT_NE(bench.arm.fault_text().find("reset"), std::string::npos) << bench.arm.fault_text();
  bench.twin().reset();
  EXPECT_TRUE(bench.becomes_ready());
}

/// A run of a swing, with strangers at both ends or without them.
struct SwingRun {
  std::vector<JointVector> told;
  hw::fri::ClientReport client;
  hw::fri::EmulatorCounts emulator;
};
SwingRun run_with_strangers(bool strangers) {
  FriBench bench;
  EXPECT_TRUE(bench.becomes_ready());
  bench.start();
  auto& wire = bench.twin().wire();
  const Endpoint driver{hw::kLoopback, hw::fri::kPort}, controller{hw::kLoopback, 50'000};
  const auto elsewhere = std::move(*wire.open_datagrams({0x0A00'0001, 77}));
  const auto same_host = std::move(*wire.open_datagrams({0, 78}));
  hw::fri::Measurement forged;
  forged.state = State::kMonitor;
  std::array<std::byte, hw::fri::kMeasurementSize> measurement{};
  std::array<std::byte, hw::fri::kCommandSize> command{};
  for (int i = 0; i < 500; ++i) {
    if (strangers) {
      forged.sequence = static_cast<std::uint16_t>(i);
      hw::fri::encode(forged, measurement);
      hw::fri::encode(hw::fri::Command{}, command);
      (void)elsewhere->send(measurement, driver);  // another host
      (void)same_host->send(measurement, driver);  // another port
      (void)elsewhere->send(command, controller);
      (void)same_host->send(command, controller);  // never the answer to anything: counter 0
      (void)same_host->send(std::span(command).first(100), controller);
    }
    bench.cycle();
  }
  return {[&] {
            std::vector<JointVector> told;
            for (const auto& set_point : bench.rig.tap->told) told.push_back(set_point.q);
            return told;
          }(),
          bench.report(), bench.twin().emulator().counts()};
}

TEST(FriWire, PacketsOfStrangersChangeNothingAndAreCounted) {
  const SwingRun quiet = run_with_strangers(false), noisy = run_with_strangers(true);
  EXPECT_EQ(quiet.told, noisy.told) << "bit for bit";
  EXPECT_EQ(quiet.client.strangers, 0u);
  EXPECT_EQ(noisy.client.strangers, 1000u);
  EXPECT_EQ(noisy.emulator.strangers, 500u);
  EXPECT_EQ(noisy.emulator.misread, 500u);
}

TEST(FriWire, TheSameSeedGivesTheSameRunAndAnotherSeedAnother) {
  const auto run = [](std::uint64_t seed) {
    FriBench bench(lossy(0.05), seed);
    (void)bench.becomes_ready();
    bench.start();
    std::vector<std::byte> states;
    for (int i = 0; i < 1000; ++i) {
      bench.cycle();
      states.insert(states.end(), bench.twin().state().begin(), bench.twin().state().end());
    }
    return states;
  };
  EXPECT_EQ(run(5), run(5));
  EXPECT_NE(run(5), run(6));
}

}  // namespace
}  // namespace takt::test
