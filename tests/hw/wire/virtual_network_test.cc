// What the virtual wire does to datagrams and streams, and that it does it again.
#include "hw/wire/virtual_network.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

namespace takt::hw {
namespace {

constexpr VirtualFaults kBad{.wire = {.transport = 200'000,
                                      .jitter = 500'000,
                                      .loss = 0.05,
                                      .repeat = 0.05,
                                      .reorder = 0.05,
                                      .hold_back = 2'500'000},
                             .corrupt = 0.05,
                             .truncate = 0.05};

struct Arrival {
  Nanoseconds time = 0;
  std::vector<std::byte> bytes;
  bool operator==(const Arrival&) const = default;
};

/// A datagram with its number in each of 16 bytes, every millisecond.
std::vector<Arrival> arrivals(const VirtualFaults& faults, int count, std::uint64_t seed) {
  VirtualClock clock;
  VirtualNetwork network(clock, seed, faults);
  const auto a = std::move(*network.open_datagrams({0, 100})), b = std::move(*network.open_datagrams({0, 200}));
  std::vector<Arrival> result;
  std::array<std::byte, 16> bytes{};
  for (int i = 0; i < count + 10; ++i) {
    const Nanoseconds now = i * kMillisecond;
    while (network.next_arrival() <= now) {
      clock.set(network.next_arrival());
      const auto received = b->receive(bytes);
      if (!received) return {};
      result.push_back({clock.now(), {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(received->size)}});
    }
    clock.set(now);
    bytes.fill(std::byte(i));
    if (i < count) (void)a->send(bytes, {kLoopback, 200});
  }
  return result;
}

TEST(VirtualNetwork, WithoutFaultsAllArriveAsSentAfterTheTransportTime) {
  const auto list = arrivals({.wire = {.transport = 200'000}}, 50, 1);
  ASSERT_EQ(list.size(), 50u);
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(list[i].time, static_cast<Nanoseconds>(i) * kMillisecond + 200'000);
    EXPECT_EQ(list[i].bytes, std::vector(16, std::byte(i)));
  }
}

TEST(VirtualNetwork, FaultsComeAsOftenAsTheirSharesSayAndRepeatBySeed) {
  constexpr int kCount = 20'000;
  const auto list = arrivals(kBad, kCount, 3);
  int damaged = 0, shorter = 0;
  for (const Arrival& arrival : list) {
    const auto differs = [&](std::byte b) { return b != arrival.bytes.front(); };
    if (arrival.bytes.size() < 16) ++shorter;
    if (arrival.bytes.size() == 16 && std::ranges::any_of(arrival.bytes, differs)) ++damaged;
  }
  const auto count = static_cast<double>(list.size());
  EXPECT_NEAR(count / kCount, 0.95 * 1.05, 0.01);
  EXPECT_NEAR(shorter / count, 0.05, 0.006);
  EXPECT_NEAR(damaged / count, 0.05 * 0.95, 0.006);
  EXPECT_EQ(list, arrivals(kBad, kCount, 3));
  EXPECT_NE(list, arrivals(kBad, kCount, 4));
}

TEST(VirtualNetwork, LosesExactlySoManyInARowWhenTold) {
  VirtualClock clock;
  VirtualNetwork network(clock, 1);
  const auto a = std::move(*network.open_datagrams({0, 100})), b = std::move(*network.open_datagrams({0, 200}));
  network.lose_next(200, 20);
  std::vector<int> came;
  for (int i = 0; i < 40; ++i) {
    std::array<std::byte, 4> bytes{std::byte(i)};
    (void)a->send(bytes, {kLoopback, 200});
    if (b->receive(bytes)) came.push_back(static_cast<int>(bytes[0]));
  }
  ASSERT_EQ(came.size(), 20u);
  EXPECT_EQ(came.front(), 20);
  EXPECT_EQ(network.counts().dropped, 20u);
}

TEST(VirtualNetwork, APulledCableLosesDatagramsAndStallsStreams) {
  VirtualClock clock;
  VirtualNetwork network(clock, 1, {.wire = {.transport = 100'000}});
  const auto a = std::move(*network.open_datagrams({0, 100})), b = std::move(*network.open_datagrams({0, 200}));
  const auto listener = std::move(*network.listen({0, 300}));
  const auto client = std::move(*network.connect({kLoopback, 300}));
  clock.set(kMillisecond);
  const auto server = listener->accept();
  ASSERT_TRUE(server);
  network.set_cut(true);
  std::array<std::byte, 4> bytes{std::byte{7}};
  (void)a->send(bytes, {kLoopback, 200});
  EXPECT_EQ(client->send(bytes), 4u);
  clock.set(kSecond);
  EXPECT_FALSE(b->receive(bytes));
  EXPECT_EQ(server->receive(bytes), 0u);
  network.set_cut(false);
  clock.set(kSecond + 50'000);
  EXPECT_EQ(server->receive(bytes), 0u) << "it leaves only now";
  clock.set(kSecond + 100'000);
  EXPECT_EQ(server->receive(bytes), 4u);
  EXPECT_EQ(bytes[0], std::byte{7});
  EXPECT_FALSE(b->receive(bytes)) << "a datagram is gone";
}

TEST(VirtualNetwork, AStrangerShowsItsOwnAddress) {
  VirtualClock clock;
  VirtualNetwork network(clock, 1);
  const Endpoint stranger{0x0A00'0001, 100};
  const auto a = std::move(*network.open_datagrams(stranger)), b = std::move(*network.open_datagrams({0, 200}));
  std::array<std::byte, 4> bytes{};
  (void)a->send(bytes, {kLoopback, 200});
  const auto received = b->receive(bytes);
  ASSERT_TRUE(received);
  EXPECT_EQ(received->from, stranger);
}

}  // namespace
}  // namespace takt::hw
