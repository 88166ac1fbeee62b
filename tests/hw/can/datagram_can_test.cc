// CAN frames in datagrams: what is damaged or somebody else's changes nothing, as on a bus.
#include "hw/can/datagram_can.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "hw/can/socket_can.h"
#include "hw/wire/virtual_network.h"

namespace takt::hw {
namespace {

CanFrame frame(std::uint32_t id, std::initializer_list<int> data) {
  CanFrame frame{.id = id, .size = static_cast<std::uint8_t>(data.size())};
  std::ranges::transform(data, frame.data.begin(), [](int byte) { return static_cast<std::byte>(byte); });
  return frame;
}

TEST(DatagramCanCode, AFrameComesBackAsItWas) {
  for (const CanFrame& sent : {frame(0, {}), frame(0x7FF, {1, 2, 3, 4, 5, 6, 7, 255}), frame(0x185, {0x37, 0x02})}) {
    const auto received = decode_can(encode(sent));
    ASSERT_TRUE(received);
    EXPECT_EQ(*received, sent);
  }
}

TEST(DatagramCanCode, BytesAreWhereThePageSaysThatTheyAre) {
  const CanDatagram bytes = encode(frame(0x123, {0xAB}));
  const auto at = [&](std::size_t i) { return std::to_integer<int>(bytes[i]); };
  EXPECT_EQ(at(0), 0x23);
  EXPECT_EQ(at(1), 0x01);
  EXPECT_EQ(at(4), 1);
  EXPECT_EQ(at(8), 0xAB);
}

TEST(DatagramCanCode, EachFlippedBitIsFound) {
  const CanDatagram good = encode(frame(0x201, {15, 0, 1, 2, 3, 4, 8}));
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    CanDatagram bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    EXPECT_FALSE(decode_can(bad)) << bit;
  }
}

TEST(DatagramCanCode, EveryOtherLengthIsRefused) {
  std::array<std::byte, kCanDatagramSize + 8> bytes{};
  std::ranges::copy(encode(frame(0x80, {})), bytes.begin());
  for (std::size_t size = 0; size <= bytes.size(); ++size)
    EXPECT_EQ(decode_can(std::span(bytes).first(size)).has_value(), size == kCanDatagramSize) << size;
}

TEST(DatagramCanCode, AnIdentifierThatNoFrameHasIsRefusedWithARightChecksumToo) {
  EXPECT_FALSE(decode_can(encode(frame(0x800, {}))));
}

/// The datagram with the right checksum for what it says now: CRC-32 by its definition, bits as a polynomial.
CanDatagram sealed(CanDatagram datagram) {
  std::uint32_t rest = 0xFFFF'FFFF;
  for (std::size_t bit = 0; bit < 16 * 8; ++bit) {
    const bool in = (std::to_integer<unsigned>(datagram[bit / 8]) >> bit % 8 & 1u) != 0;
    const bool out = (rest & 1u) != 0;
    rest >>= 1;
    if (in != out) rest ^= 0xEDB8'8320;
  }
  for (std::size_t i = 0; i < 4; ++i) datagram[16 + i] = static_cast<std::byte>(~rest >> (8 * i));
  return datagram;
}

TEST(DatagramCanCode, WhatNoFrameHasIsRefusedWithARightChecksumToo) {
  const CanDatagram good = encode(frame(0x201, {15, 0, 1}));
  ASSERT_EQ(sealed(good), good);
  const auto with = [&](std::size_t at, int byte) {
    CanDatagram bad = good;
    bad[at] = static_cast<std::byte>(byte);
    return decode_can(sealed(bad));
  };
  EXPECT_TRUE(with(8, 99)) << "other data are another frame";
  EXPECT_FALSE(with(4, 9)) << "more than eight bytes";
  EXPECT_FALSE(with(4, 255));
  EXPECT_FALSE(with(4, 2)) << "data beyond its size";
  for (const std::size_t filler : {5, 6, 7, 11, 15}) EXPECT_FALSE(with(filler, 1)) << filler;
}

class DatagramCanLink : public testing::Test {
 protected:
  std::unique_ptr<DatagramLink> open(const Endpoint& local) { return std::move(*network.open_datagrams(local)); }
  void pass(Nanoseconds time) { clock.set(clock.now() + time); }

  VirtualClock clock;
  VirtualNetwork network{clock, 1};
  const Endpoint here{kLoopback, 400}, there{kLoopback, 500};
  DatagramCan drives{open(there), {}, clock}, master{open(here), there, clock};
};

TEST_F(DatagramCanLink, AnOpenEndAnswersWhoeverSpokeFirst) {
  EXPECT_FALSE(drives.send(frame(1, {}))) << "nobody is there yet";
  ASSERT_TRUE(master.send(frame(2, {7})));
  EXPECT_EQ(drives.receive(), frame(2, {7}));
  ASSERT_TRUE(drives.send(frame(3, {8})));
  EXPECT_EQ(master.receive(), frame(3, {8}));
  EXPECT_FALSE(master.receive());
}

TEST_F(DatagramCanLink, StrangersAndRubbishAreCountedAndChangeNothing) {
  DatagramCan stranger(open({kLoopback, 600}), there, clock), other(open({kLoopback, 601}), here, clock);
  ASSERT_TRUE(master.send(frame(2, {})));
  ASSERT_TRUE(stranger.send(frame(5, {})));
  EXPECT_EQ(drives.receive(), frame(2, {}));
  EXPECT_FALSE(drives.receive());
  EXPECT_EQ(drives.counts().strangers, 1u);
  ASSERT_TRUE(other.send(frame(6, {})));
  EXPECT_FALSE(master.receive()) << "its peer is fixed";
  EXPECT_EQ(master.counts().strangers, 1u);
  const auto raw = open({kLoopback, 602});
  const std::array<std::byte, 7> rubbish{};
  ASSERT_TRUE(raw->send(rubbish, there));
  EXPECT_FALSE(drives.receive());
  EXPECT_EQ(drives.counts().misread, 1u);
  // A second master has its turn once the first one has been silent.
  pass(2 * kSecond);
  ASSERT_TRUE(stranger.send(frame(5, {})));
  EXPECT_EQ(drives.receive(), frame(5, {}));
}

/// A link that gives what it is told to, as a system does.
struct OddLink final : DatagramLink {
  bool send(std::span<const std::byte>, const Endpoint&) override { return false; }
  std::optional<Received> receive(std::span<std::byte>) override { return std::exchange(next, {}); }
  bool wait(Nanoseconds) override { return true; }
  [[nodiscard]] Endpoint local() const override { return {}; }
  [[nodiscard]] DatagramCounts counts() const override { return {}; }
  std::optional<Received> next;
};

TEST_F(DatagramCanLink, WhatTheSystemDoesNotSendOrCutsOffIsCounted) {
  auto link = std::make_unique<OddLink>();
  link->next = DatagramLink::Received{.size = DatagramLink::kLargest + 1, .from = there};
  DatagramCan odd(std::move(link), there, clock);
  EXPECT_FALSE(odd.send(frame(1, {})));
  EXPECT_EQ(odd.counts().unsent, 1u);
  EXPECT_FALSE(odd.receive()) << "larger than any datagram of ours";
  EXPECT_EQ(odd.counts().misread, 1u);
}

TEST_F(DatagramCanLink, TheOpenEndKeepsItsPeerWhileItIsHeard) {
  DatagramCan stranger(open({kLoopback, 600}), there, clock);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(master.send(frame(2, {})));
    EXPECT_EQ(drives.receive(), frame(2, {}));
    pass(900 * kMillisecond);
    ASSERT_TRUE(stranger.send(frame(5, {})));
    EXPECT_FALSE(drives.receive()) << i;
  }
  EXPECT_EQ(drives.counts().strangers, 3u);
}

TEST(SocketCan, AnInterfaceThatIsNotThereIsRefusedByItsName) {
  const auto link = open_socket_can("takt-none");
  ASSERT_FALSE(link);
  EXPECT_EQ(link.error().list().front().code, Code::kSystem);
  EXPECT_NE(link.error().to_string().find("takt-none"), std::string::npos);
}

TEST(SocketCan, NamesOfInterfaces) {
  for (const char* good : {"can0", "vcan1", "slcan_2", "a"}) EXPECT_TRUE(is_interface_name(good)) << good;
  for (const char* bad : {"", "127.0.0.1", "can 0", "can0:5", "an_interface_name"})
    EXPECT_FALSE(is_interface_name(bad)) << bad;
}

}  // namespace
}  // namespace takt::hw
