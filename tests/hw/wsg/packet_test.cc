// Packets and payloads of the WSG interface, against published examples, and cut at every byte.
#include "hw/wsg/protocol/commands.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace takt::hw::wsg::packet_test {
namespace {

std::string bytes(std::initializer_list<unsigned> values) {
  std::string text;
  for (const unsigned value : values) text += static_cast<char>(value);
  return text;
}

/// Published examples of the interface: the checksum is not ours.
struct Example {
  const char* what;
  std::uint8_t command;
  std::string payload, packet;
};
const std::vector<Example>& examples() {
  static const std::vector<Example> all{
      {"signal", 0x01, "", bytes({0xAA, 0xAA, 0xAA, 0x01, 0, 0, 0xE8, 0x10})},
      {"two bytes", 0x01, bytes({0x12, 0x34}), bytes({0xAA, 0xAA, 0xAA, 0x01, 2, 0, 0x12, 0x34, 0x6D, 0x66})},
      {"homed", 0x20, bytes({0, 0}), bytes({0xAA, 0xAA, 0xAA, 0x20, 2, 0, 0, 0, 0xB3, 0xFD})},
      {"unknown", 0x90, bytes({0x0E, 0}), bytes({0xAA, 0xAA, 0xAA, 0x90, 2, 0, 0x0E, 0, 0xFD, 0x02})},
      {"acceleration", 0x30, bytes({0, 0, 0, 0, 0x16, 0x43}),
       bytes({0xAA, 0xAA, 0xAA, 0x30, 6, 0, 0, 0, 0, 0, 0x16, 0x43, 0xDC, 0xCB})},
      {"pending", 0x21, bytes({0x1A, 0}), bytes({0xAA, 0xAA, 0xAA, 0x21, 2, 0, 0x1A, 0, 0x67, 0xCB})},
      {"moved", 0x21, bytes({0, 0}), bytes({0xAA, 0xAA, 0xAA, 0x21, 2, 0, 0, 0, 0x28, 0x04})}};
  return all;
}

std::vector<Packet> all_of(PacketParser& parser) {
  std::vector<Packet> packets;
  while (auto packet = parser.next()) packets.push_back(std::move(*packet));
  return packets;
}

TEST(WsgPacket, PublishedExamples) {
  EXPECT_EQ(checksum("\xAA\xAA\xAA"), 0x50F5);
  for (const Example& example : examples()) {
    std::string out;
    append_packet(out, example.command, example.payload);
    EXPECT_EQ(out, example.packet) << example.what;
    PacketParser parser;
    parser.feed(example.packet);
    const auto packets = all_of(parser);
    ASSERT_EQ(packets.size(), 1u) << example.what;
    EXPECT_TRUE(packets[0].intact);
    EXPECT_EQ(packets[0].command, example.command);
    EXPECT_EQ(packets[0].payload, example.payload);
  }
  const auto acceleration = parse_answer(examples()[4].payload);
  ASSERT_TRUE(acceleration);
  EXPECT_DOUBLE_EQ(parse_number(Command::kSetAcceleration, acceleration->parameters).value(), 0.15);
  EXPECT_EQ(parse_answer(examples()[3].payload)->status, Status::kUnknownCommand);
  EXPECT_EQ(parse_answer(examples()[5].payload)->status, Status::kPending);
}

/// A stream of packets with something between them.
std::string stream() {
  std::string stream = "\xAA noise \xAA\xAA";
  for (const Example& example : examples()) stream += example.packet + "\xAA";
  append_packet(stream, 0x06, "\xAA\xAA\xAA\x21");
  return stream;
}

TEST(WsgPacket, MeansTheSameHoweverItIsCut) {
  const std::string all = stream();
  for (std::size_t a = 0; a <= all.size(); ++a) {
    for (std::size_t b = a; b <= all.size(); ++b) {
      PacketParser parser;
      std::vector<Packet> packets;
      for (const std::string& piece : {all.substr(0, a), all.substr(a, b - a), all.substr(b)}) {
        parser.feed(piece);
        for (Packet& packet : all_of(parser))
          if (packet.intact) packets.push_back(std::move(packet));
      }
      ASSERT_EQ(packets.size(), examples().size() + 1) << a << " " << b;
      for (std::size_t i = 0; i < examples().size(); ++i) ASSERT_EQ(packets[i].payload, examples()[i].payload);
      ASSERT_EQ(packets.back().payload, "\xAA\xAA\xAA\x21");
    }
  }
}

TEST(WsgPacket, AFlippedBitCostsOnePacketAtMost) {
  const std::string packet = examples()[4].packet;
  for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
    std::string bad = packet;
    bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ 1 << bit % 8);
    PacketParser parser;
    // More than any size that a flipped bit can claim and that is believed.
    parser.feed(bad + examples()[0].packet + std::string(kLargestPayload + kHeaderSize + kChecksumSize, '\0'));
    std::vector<Packet> intact;
    for (Packet& one : all_of(parser))
      if (one.intact) intact.push_back(std::move(one));
    ASSERT_EQ(intact.size(), 1u) << "bit " << bit;
    EXPECT_EQ(intact[0].command, examples()[0].command);
  }
}

TEST(WsgPacket, KeepsNoMoreThanAPacket) {
  PacketParser parser;
  Random random(7);
  for (int i = 0; i < 2000; ++i) {
    std::string noise(1 + random.bits() % 64, '\0');
    for (char& byte : noise) byte = random.bits() % 3 == 0 ? static_cast<char>(random.bits()) : '\xAA';
    parser.feed(noise);
    (void)all_of(parser);
    ASSERT_LE(parser.waiting(), kLargestPayload + kHeaderSize + kChecksumSize);
  }
  EXPECT_GT(parser.skipped(), 0u);
  parser.reset();
  EXPECT_EQ(parser.waiting(), 0u);
}

TEST(WsgPayload, UnitsAndFlags) {
  const std::string move = motion_payload(Command::kMove, {.width = 0.055, .speed = 0.42, .stop_on_block = true});
  EXPECT_EQ(move, bytes({0x02, 0, 0, 0x5C, 0x42, 0, 0, 0xD2, 0x43})) << "55 mm, 420 mm/s";
  const auto moved = parse_motion(Command::kMove, move);
  ASSERT_TRUE(moved);
  EXPECT_TRUE(moved->stop_on_block);
  EXPECT_FALSE(moved->relative);
  EXPECT_DOUBLE_EQ(moved->width, 0.055);
  EXPECT_EQ(motion_payload(Command::kGrasp, {.width = 0.055, .speed = 0.42}), move.substr(1));
  EXPECT_EQ(motion_payload(Command::kMove, {.relative = true})[0], 1);
  EXPECT_TRUE(parse_motion(Command::kMove, motion_payload(Command::kMove, {.relative = true}))->relative);
  EXPECT_EQ(number_payload(Command::kSetForce, 80.0), bytes({0, 0, 0xA0, 0x42})) << "N as they are";
  EXPECT_EQ(number_payload(Command::kSetAcceleration, 0.15), bytes({0, 0, 0x16, 0x43})) << "150 mm/s^2";
  EXPECT_EQ(auto_update_payload({true, true, 0x0214}), bytes({3, 0x14, 0x02}));
  EXPECT_EQ(auto_update_payload({}), bytes({0, 0, 0}));
  EXPECT_EQ(number_payload(Command::kGetForce, 5.0), number_payload(Command::kForce, 5.0));
  const auto update = parse_auto_update(bytes({1, 8, 0}));
  ASSERT_TRUE(update);
  EXPECT_TRUE(update->on);
  EXPECT_FALSE(update->on_change_only);
  EXPECT_EQ(update->period_ms, 8);
  const Limits limits{0.11, 0.005, 0.42, 0.1, 5.0, 5.0, 80.0, 120.0};
  const auto read = parse_limits(limits_payload(limits));
  ASSERT_TRUE(read);
  EXPECT_NEAR(read->stroke, 0.11, 1e-9);
  EXPECT_NEAR(read->force_overdrive, 120.0, 1e-9);
}

TEST(WsgPayload, AnotherLengthIsNone) {
  for (const Command command : {Command::kMove, Command::kGrasp, Command::kRelease}) {
    const std::string right = motion_payload(command, {});
    for (std::size_t size = 0; size < 12; ++size)
      EXPECT_EQ(parse_motion(command, std::string(size, '\0')).has_value(), size == right.size());
  }
  for (std::size_t size = 0; size < 40; ++size) {
    const std::string zeros(size, '\0');
    EXPECT_EQ(parse_number(Command::kWidth, zeros).has_value(), size == 4);
    EXPECT_EQ(parse_auto_update(zeros).has_value(), size == 3);
    EXPECT_EQ(parse_limits(zeros).has_value(), size == 32);
    EXPECT_EQ(parse_answer(zeros).has_value(), size >= 2);
  }
}

TEST(WsgPayload, EveryStatusHasAName) {
  EXPECT_EQ(name_of(Status::kSuccess), "success");
  EXPECT_EQ(name_of(Status::kPending), "pending");
  EXPECT_EQ(name_of(Status::kFileExists), "file exists");
  EXPECT_EQ(name_of(static_cast<Status>(31)), "unknown status");
  std::string packet;
  append_answer(packet, Command::kWidth, Status::kAccessDenied, "lost");
  EXPECT_EQ(packet.size(), kHeaderSize + 2 + kChecksumSize) << "parameters come with success only";
  packet.clear();
  append_answer(packet, Command::kWidth, Status::kSuccess, "kept");
  EXPECT_EQ(packet.size(), kHeaderSize + 2 + 4 + kChecksumSize);
}

}  // namespace
}  // namespace takt::hw::wsg::packet_test
