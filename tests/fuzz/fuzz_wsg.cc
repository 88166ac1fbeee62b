// Any bytes between a WSG gripper and its driver leave both alive and their machine told what it can do; a stream means
// the same however it is cut. The first byte of an input says to whom the rest is sent.
#include <cmath>
#include <memory>
#include <string_view>
#include <vector>

#include "hw/emulators/wsg/emulator.h"
#include "hw/wsg/twin.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"
#include "tests/support/fake_signals.h"
#include "tests/support/kinematic_gripper.h"

namespace takt {
namespace {

using namespace hw::wsg;  // NOLINT

std::shared_ptr<const device::GripperDescription> described() {
  static const auto gripper = std::make_shared<const device::GripperDescription>(test::fake_gripper_description());
  return gripper;
}

std::vector<Packet> packets_of(std::string_view bytes, std::size_t cut) {
  PacketParser parser;
  std::vector<Packet> packets;
  for (const std::string_view piece : {bytes.substr(0, cut), bytes.substr(cut)}) {
    parser.feed(piece);
    while (auto packet = parser.next()) packets.push_back(std::move(*packet));
  }
  test::demand(parser.waiting() <= kHeaderSize + kLargestPayload + kChecksumSize, "a parser keeps one packet at most");
  return packets;
}

void expect_the_same_when_cut(std::string_view bytes) {
  const auto whole = packets_of(bytes, 0);
  for (const std::size_t cut : {bytes.size() / 3, bytes.size() / 2, bytes.size()}) {
    const auto pieces = packets_of(bytes, cut);
    test::demand(pieces.size() == whole.size(), "a stream means the same however it is cut");
    for (std::size_t i = 0; i < whole.size(); ++i)
      test::demand(pieces[i].payload == whole[i].payload && pieces[i].intact == whole[i].intact, "as before");
  }
}

/// The packets of an input with checksums that are right, so that they are looked at.
std::string with_checksums(std::string_view bytes) {
  std::string out;
  for (std::size_t at = 0; at + 2 <= bytes.size();) {
    const auto command = static_cast<std::uint8_t>(bytes[at]);
    const std::size_t size =
        std::min<std::size_t>(static_cast<std::uint8_t>(bytes[at + 1]) % 40, bytes.size() - at - 2);
    append_packet(out, command, bytes.substr(at + 2, size));
    at += 2 + size;
  }
  return out;
}

/// A peer that says what the input says, to a gripper.
void disturb_gripper(std::string_view bytes) {
  VirtualClock clock;
  hw::VirtualNetwork network(clock, 1);
  const auto machine = std::make_shared<test::KinematicGripper>(0.11, 0.04);
  Emulator emulator({}, described(), network, machine);
  (void)emulator.listen({hw::kLoopback, kPort});
  auto link = *network.connect({hw::kLoopback, kPort});
  std::vector<std::byte> sink(4096);
  for (int k = 0; k < 60; ++k) {
    clock.set(k * kMillisecond);
    machine->advance();
    emulator.advance(clock.now());
    if (k == 5) (void)link->send(std::as_bytes(std::span(bytes)));
    (void)link->receive(sink);
  }
  const device::GripperSetPoint& told = emulator.set_point();
  const bool sane = told.sequence == 0 || (told.width >= 0.0 && told.width <= 0.11 && std::isfinite(told.speed) &&
                                           told.force >= 5.0 && told.force <= 80.0);
  test::demand(sane, "a gripper is told what it can do");
}

/// A peer that says what the input says, to a driver that is being commanded.
void disturb_driver(std::string_view bytes) {
  VirtualClock clock;
  hw::VirtualNetwork network(clock, 1);
  auto listener = *network.listen({hw::kLoopback, kPort});
  Client client({}, {"gripper", described(), kMillisecond, 1}, network, clock);
  std::unique_ptr<hw::StreamLink> link;
  device::GripperSample sample;
  std::vector<std::byte> sink(4096);
  for (int k = 0; k < 60; ++k) {
    clock.set(k * kMillisecond);
    client.poll();
    if (k == 10) client.write({.sequence = 1, .width = 0.05, .speed = 0.1, .force = 40.0});
    if (k == 40) client.reset();
    if (auto next = listener->accept()) link = std::move(next);
    if (link && k % 10 == 5) (void)link->send(std::as_bytes(std::span(bytes)));
    if (link) (void)link->receive(sink);
    if (client.read(sample)) {
      const bool finite = std::isfinite(sample.width) && std::isfinite(sample.speed) && std::isfinite(sample.force);
      test::demand(finite, "samples are finite");
    }
  }
  test::demand(client.news().size() <= 64, "what is told does not grow without bound");
}

/// A driver that runs against its gripper, and gets the input in between.
void load_bytes(std::string_view input) {
  if (input.empty()) return;
  const std::string_view bytes = input.substr(1);
  const std::string dressed = input[0] % 2 == 0 ? std::string(bytes) : with_checksums(bytes);
  expect_the_same_when_cut(dressed);
  (input[0] / 2) % 2 == 0 ? disturb_gripper(dressed) : disturb_driver(dressed);
}

}  // namespace
}  // namespace takt

namespace takt::test {

const FuzzTarget& fuzz_target() {
  static const FuzzTarget target{.words = {"\xAA\xAA\xAA", "\x21\x09", "\x25\x08", "\x26\x08", "ack",
                                           "\x43\x03\x01\x08", "\x53\x20", "\x41\x03\x01\x08", "\x1A"},
                                 .load = load_bytes,
                                 .share = 0.0,
                                 .mutate = [](std::string_view, Random&) -> std::optional<std::string> { return {}; }};
  return target;
}

}  // namespace takt::test
