#include "core/device/channel.h"

#include <atomic>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/allocation_guard.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using device::Channel;
using device::ChannelDescription;
using Written = Channel::Written;
using net::ValueType;
using testing::AllOf;

std::unique_ptr<Channel> make(const ChannelDescription& description) {
  auto channel = Channel::make(description);
  if (!channel) ADD_FAILURE() << channel.error().to_string();
  return std::move(*channel);
}

Diagnostics diagnostics_of(const ChannelDescription& description) {
  const auto channel = Channel::make(description);
  return channel ? Diagnostics() : channel.error();
}

TEST(Channel, O5_AValueFromOutsideCountsFromTheNextCycleAndTheNewestWins) {
  const auto channel = make({.name = "speed", .unit = "m/s", .initial = 0.25});
  channel->begin_cycle(0, 0);
  EXPECT_EQ(channel->slot<net::Real>().value, 0.25);
  EXPECT_FALSE(channel->age());
  EXPECT_EQ(channel->write(1.0), Written::kDone);
  EXPECT_EQ(channel->write(2.0), Written::kDone);
  EXPECT_EQ(channel->slot<net::Real>().value, 0.25);
  channel->begin_cycle(1, kMillisecond);
  EXPECT_EQ(channel->slot<net::Real>().value, 2.0);
  EXPECT_TRUE(channel->latched());
  EXPECT_EQ(channel->age(), Nanoseconds{0});
  channel->begin_cycle(2, 2 * kMillisecond);
  EXPECT_FALSE(channel->latched());
  EXPECT_EQ(channel->age(), kMillisecond);
}

TEST(Channel, TheValueBeforeTheNewestIsKeptWithTheTimeBetweenThem) {
  const auto channel = make({.name = "speed", .initial = 7.0, .timeout = 5 * kMillisecond});
  const auto cycle = [&channel](std::int64_t k) { channel->begin_cycle(k, k * kMillisecond); };
  EXPECT_EQ(channel->write(1.0), Written::kDone);
  cycle(0);
  EXPECT_EQ(channel->previous<net::Real>().null, 1u) << "an initial value came at no time";
  EXPECT_EQ(channel->interval(), 0);
  cycle(1);
  EXPECT_EQ(channel->write(2.0), Written::kDone);
  for (std::int64_t k = 2; k <= 4; ++k) {
    cycle(k);
    EXPECT_EQ(channel->previous<net::Real>().value, 1.0);
    EXPECT_EQ(channel->interval(), 2 * kMillisecond);
  }
  for (std::int64_t k = 5; k <= 9; ++k) cycle(k);
  EXPECT_EQ(channel->write(3.0), Written::kDone);
  cycle(10);
  EXPECT_EQ(channel->slot<net::Real>().value, 3.0);
  EXPECT_EQ(channel->previous<net::Real>().null, 1u) << "it had grown too old";
}

TEST(Channel, O5_NullBeforeTheFirstValueAndAfterTheTimeout) {
  const auto channel = make({.name = "speed", .timeout = 2 * kMillisecond});
  channel->begin_cycle(0, 0);
  EXPECT_EQ(channel->slot<net::Real>().null, 1u);
  EXPECT_EQ(channel->write(3.0), Written::kDone);
  for (std::int64_t k = 1; k <= 3; ++k) {
    channel->begin_cycle(k, k * kMillisecond);
    EXPECT_EQ(channel->slot<net::Real>().null, 0u) << k;
  }
  channel->begin_cycle(4, 4 * kMillisecond);
  EXPECT_EQ(channel->slot<net::Real>().null, 1u);
  EXPECT_EQ(channel->age(), 3 * kMillisecond) << "the age goes on";
  EXPECT_EQ(channel->write(4.0), Written::kDone);
  channel->begin_cycle(5, 5 * kMillisecond);
  EXPECT_EQ(channel->slot<net::Real>().value, 4.0);
}

TEST(Channel, N5_WhatIsNotFiniteIsNull) {
  const auto channel = make({.name = "speed", .initial = 1.0});
  EXPECT_EQ(channel->write(std::numeric_limits<double>::quiet_NaN()), Written::kDone);
  channel->begin_cycle(0, 0);
  EXPECT_EQ(channel->slot<net::Real>().null, 1u);
  EXPECT_EQ(channel->write(1.0), Written::kDone);
  EXPECT_EQ(channel->write_null(), Written::kDone);
  channel->begin_cycle(1, kMillisecond);
  EXPECT_EQ(channel->slot<net::Real>().null, 1u);
}

TEST(Channel, WritersThatMayNotAreToldSo) {
  const auto outside = make({.name = "speed"});
  EXPECT_EQ(outside->write(true), Written::kWrongType);
  EXPECT_EQ(outside->write(device::ChannelValue(net::Integer{1})), Written::kWrongType);
  const auto net = make({.name = "force", .writer = ChannelDescription::Writer::kNet});
  EXPECT_EQ(net->write(1.0), Written::kNetWrites);
  EXPECT_EQ(net->write_null(), Written::kNetWrites);
}

TEST(Channel, WhatIsWrongIsSaidAtOnce) {
  EXPECT_THAT(diagnostics_of({.name = "", .unit = "parsec", .frame = "a>b", .initial = true, .timeout = -1}),
              AllOf(Reports(Code::kMissing, "/name"), Reports(Code::kInvalidValue, "/unit", {"parsec"}),
                    Reports(Code::kInvalidValue, "/frame", {"a>b", "Real"}),
                    Reports(Code::kTypeMismatch, "/initial", {"Boolean", "Real"}),
                    Reports(Code::kOutOfRange, "/timeout", {"0"})));
  EXPECT_THAT(diagnostics_of({.name = "x", .unit = "u"}), Reports(Code::kInvalidValue, "/unit", {"u"}));
  EXPECT_THAT(diagnostics_of({.name = "x", .unit = "N,N*m"}), Reports(Code::kInvalidValue, "/unit", {"N,N*m"}));
  EXPECT_THAT(diagnostics_of({.name = "x", .type = ValueType::kBoolean, .unit = "m"}),
              Reports(Code::kConflict, "/unit", {"Boolean", "m"}));
  EXPECT_THAT(diagnostics_of({.name = "x", .type = ValueType::kFrame, .frame = "a"}),
              Reports(Code::kInvalidValue, "/frame", {"a", "A>B"}));
  EXPECT_TRUE(diagnostics_of({.name = "x", .type = ValueType::kWrench, .unit = "N,N*m", .frame = "flange"}).empty());
}

TEST(Channel, D4_EveryBitOfTheValueAndItsAgeIsInTheState) {
  const auto state = [](const Channel& channel) {
    device::StateWords words;
    channel.add_state(words);
    const auto bytes = words.bytes();
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  };
  const auto a = make({.name = "x", .initial = 1.0}), b = make({.name = "x", .initial = 1.0});
  a->begin_cycle(0, 0);
  b->begin_cycle(0, 0);
  EXPECT_EQ(state(*a), state(*b));
  (void)b->write(std::nextafter(1.0, 2.0));
  (void)a->write(1.0);
  a->begin_cycle(1, kMillisecond);
  b->begin_cycle(1, kMillisecond);
  EXPECT_NE(state(*a), state(*b));
  (void)b->write(1.0);
  a->begin_cycle(2, 2 * kMillisecond);
  b->begin_cycle(2, 2 * kMillisecond);
  EXPECT_NE(state(*a), state(*b)) << "equal values of different age";
}

/// Many threads write, the cycle reads: every value is whole, and each writer's values come in order.
TEST(Channel, O5_ManyWritersTearNothing) {
  constexpr int kWriters = 4, kValues = 20'000;
  const auto channel = make({.name = "x", .type = ValueType::kVector});
  std::atomic<int> running = kWriters;
  std::atomic<int> busy = 0;
  std::vector<std::thread> writers;
  for (int w = 0; w < kWriters; ++w) {
    writers.emplace_back([&, w] {
      for (int i = 1; i <= kValues; ++i)
        if (channel->write(net::Vector(w, i, w + i)) != Written::kDone) ++busy;
      --running;
    });
  }
  std::array<double, kWriters> last{};
  bool more = true;
  for (std::int64_t k = 0; more; ++k) {
    more = running > 0;
    channel->begin_cycle(k, k * kMillisecond);
    const auto& slot = channel->slot<net::Vector>();
    if (!channel->latched()) continue;
    ASSERT_EQ(slot.value.z(), slot.value.x() + slot.value.y());
    double& before = last.at(static_cast<std::size_t>(slot.value.x()));
    ASSERT_GT(slot.value.y(), before);
    before = slot.value.y();
  }
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(busy, 0) << "four writers never use up sixteen cells";
  EXPECT_THAT(last, testing::Contains(kValues)) << "the very last value arrives";
}

TEST(Channel, NothingIsAllocatedByWriterOrCycle) {
  const auto channel = make({.name = "x", .type = ValueType::kJoints});
  const net::JointArray value{Eigen::VectorXd::Ones(7)};
  const AllocationGuard guard;
  for (std::int64_t k = 0; k < 100; ++k) {
    (void)channel->write(value);
    channel->begin_cycle(k, k * kMillisecond);
    device::StateWords words;
    channel->add_state(words);
  }
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace takt::test
