// Clocks that run wrong and wires that lose, repeat and delay: the same seed gives the same faults.
#include <vector>

#include <gtest/gtest.h>

#include "core/emulation/device_clock.h"
#include "core/emulation/wire.h"

namespace takt::emulation {
namespace {

struct Outcome {
  std::vector<int> order;
  std::vector<Nanoseconds> delays;
};

/// Sends 0..count-1 one millisecond apart and takes what arrives.
Outcome run(const WireFaults& faults, int count, std::uint64_t seed) {
  Wire<int> wire(faults, seed, "wire");
  Outcome outcome;
  const auto receive_until = [&](Nanoseconds now) {
    while (wire.next_arrival() <= now) {
      const Nanoseconds at = wire.next_arrival();
      outcome.order.push_back(wire.receive());
      outcome.delays.push_back(at - outcome.order.back() * kMillisecond);
    }
  };
  for (int i = 0; i < count; ++i) {
    receive_until(i * kMillisecond);
    wire.send(i, i * kMillisecond);
  }
  receive_until(kSecond * 3600);
  return outcome;
}

TEST(Wire, WithoutFaultsEverythingArrivesInOrderAtOnce) {
  const Outcome outcome = run({}, 100, 1);
  ASSERT_EQ(outcome.order.size(), 100u);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(outcome.order[static_cast<std::size_t>(i)], i);
    EXPECT_EQ(outcome.delays[static_cast<std::size_t>(i)], 0);
  }
}

TEST(Wire, FaultsComeAsOftenAsTheirSharesSay) {
  constexpr int kCount = 20'000;
  const Outcome outcome = run(
      {.transport = 100'000, .jitter = 200'000, .loss = 0.1, .repeat = 0.05, .reorder = 0.02, .hold_back = 2'500'000},
      kCount, 7);
  std::vector<int> seen(kCount, 0);
  int overtaken = 0, newest = -1;
  for (std::size_t i = 0; i < outcome.order.size(); ++i) {
    const int message = outcome.order[i];
    ++seen[static_cast<std::size_t>(message)];
    if (message < newest) ++overtaken;
    newest = std::max(newest, message);
    EXPECT_GE(outcome.delays[i], 100'000);
    EXPECT_LE(outcome.delays[i], 100'000 + 2 * 200'000 + 2'500'000 + 200'000);
  }
  const auto times = [&](int n) { return static_cast<double>(std::count(seen.begin(), seen.end(), n)) / kCount; };
  EXPECT_NEAR(times(0), 0.1, 0.01);
  EXPECT_NEAR(times(2), 0.9 * 0.05, 0.006);
  EXPECT_NEAR(static_cast<double>(overtaken) / kCount, 0.9 * 0.02, 0.004);
}

TEST(Wire, TheSameSeedGivesTheSameFaults) {
  const WireFaults faults{.jitter = 300'000, .loss = 0.1, .repeat = 0.1, .reorder = 0.1, .hold_back = 2'000'000};
  const Outcome a = run(faults, 1000, 5), b = run(faults, 1000, 5), c = run(faults, 1000, 6);
  EXPECT_EQ(a.order, b.order);
  EXPECT_EQ(a.delays, b.delays);
  EXPECT_NE(a.delays, c.delays);
}

TEST(DeviceClock, RunsAheadByItsDrift) {
  const DeviceClock clock(5 * kSecond, 100e-6);
  EXPECT_EQ(clock.to_device(0), 5 * kSecond);
  EXPECT_EQ(clock.to_device(10 * kSecond), 15 * kSecond + kMillisecond);
  for (const Nanoseconds t : {Nanoseconds{1}, kMillisecond, 3600 * kSecond}) {
    EXPECT_NEAR(static_cast<double>(clock.to_core(clock.to_device(t)) - t), 0.0, 1.0);
  }
}

}  // namespace
}  // namespace takt::emulation
