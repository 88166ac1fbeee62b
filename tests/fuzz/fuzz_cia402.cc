// Any frames on the bus of drives leave driver and drives alive, and the arm behind them told finite numbers. Each
// eleven bytes of the input are a frame: identifier, size, data.
#include <algorithm>
#include <memory>
#include <string_view>
#include <vector>

#include "hw/can/datagram_can.h"
#include "hw/cia402/twin.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"
#include "tests/support/fake_arm.h"

namespace takt {
namespace {

using namespace hw::cia402;  // NOLINT
using hw::CanFrame;
using Bytes = std::span<const std::byte>;

std::vector<CanFrame> frames_in(Bytes input) {
  constexpr std::size_t kFrame = 11, kMost = 64;
  std::vector<CanFrame> frames;
  for (std::size_t at = 0; at + kFrame <= input.size() && frames.size() < kMost; at += kFrame) {
    CanFrame frame{.id = get(input, at, 2) & CanFrame::kMostId,
                   .size = static_cast<std::uint8_t>(get(input, at + 2, 1) % 9)};
    std::copy_n(input.begin() + static_cast<std::ptrdiff_t>(at) + 3, frame.size, frame.data.begin());
    frames.push_back(frame);
  }
  return frames;
}

std::shared_ptr<const device::ArmDescription> two_joints() {
  auto arm = std::make_shared<device::ArmDescription>(test::fake_arm_description(2));
  arm->cycle = 4 * kMillisecond;
  return arm;
}

/// Drives that are led, and get frames beside those of their master.
void disturb_drives(const std::vector<CanFrame>& frames) {
  const auto machine = std::make_shared<test::FakeArm>(device::JointVector::Zero(2));
  Twin twin({.device = "arm", .description = two_joints()}, {}, machine);
  device::ArmSample sample;
  Nanoseconds now = 0;
  const auto pass = [&](int cycles) {
    for (int i = 0; i < cycles; ++i, now += kMillisecond) (void)twin.read(sample);
  };
  pass(150);
  for (const CanFrame& frame : frames) {
    for (std::size_t joint = 0; joint < 2; ++joint) twin.emulator().node(joint).take(frame, now);
    pass(1);
  }
  pass(50);
  for (const auto& told : machine->sent)
    test::demand(told.q.allFinite() && told.dq.allFinite(), "an arm is told finite numbers");
}

/// A master that gets frames in place of its drives' answers.
void disturb_master(const std::vector<CanFrame>& frames) {
  VirtualClock clock;
  hw::VirtualNetwork network(clock, 1);
  const hw::Endpoint there{hw::kLoopback, hw::kCanPort}, here{hw::kLoopback, 5000};
  hw::DatagramCan drives(std::move(*network.open_datagrams(there)), here, clock);
  CanopenBus bus(*two_joints(), {},
                 std::make_unique<hw::DatagramCan>(std::move(*network.open_datagrams(here)), there, clock));
  const std::vector<DriveOutputs> outputs(2);
  for (const CanFrame& frame : frames) {
    clock.set(clock.now() + kMillisecond);
    bus.begin_cycle(clock.now());
    (void)drives.send(frame);
    if (bus.poll(clock.now())) bus.send(outputs);
    while (drives.receive()) continue;
  }
  test::demand(bus.lines().size() <= 4 * frames.size() + 4, "what is told does not grow without bound");
}

void load(std::string_view text) {
  const Bytes input = std::as_bytes(std::span(text));
  if (const auto frame = hw::decode_can(input)) {
    const auto again = hw::encode(*frame);
    test::demand(std::ranges::equal(again, input), "what was read is written as it was");
  }
  const std::vector<CanFrame> frames = frames_in(input);
  disturb_master(frames);
  disturb_drives(frames);
}

}  // namespace
}  // namespace takt

namespace takt::test {

const FuzzTarget& fuzz_target() {
  // Service data to the first node and its answers, network management, heartbeats, process data.
  static const FuzzTarget target{.words = {"\x01\x06\x08\x2F\x60\x60", "\x81\x05\x08\x43", "\x81\x05\x08\x80",
                                           "\x81\x05\x08\x60", "\x01\x07\x01\x05", "\x01\x02\x07\x0F", "\x81\x01\x07"},
                                 .load = load,
                                 .share = 0.0,
                                 .mutate = [](std::string_view, Random&) -> std::optional<std::string> { return {}; }};
  return target;
}

}  // namespace takt::test
