// Any bytes that come over the wire of FRI leave the driver alive, and the arm behind the emulated controller inside
// its range and told finite numbers. What can be read as a datagram is written again as it was.
#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "hw/fri/twin.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"
#include "tests/support/fake_arm.h"

namespace takt {
namespace {

using hw::fri::kCommandSize;
using hw::fri::kMeasurementSize;
using Bytes = std::span<const std::byte>;

/// The head of a real datagram before the input, and zeros behind it, so that inputs get past the length.
template <std::size_t size>
std::array<std::byte, size> dressed(const std::array<std::byte, size>& real, Bytes input) {
  constexpr std::size_t kHead = 8;
  std::array<std::byte, size> bytes = real;
  std::copy_n(input.begin(), std::min(input.size(), size - kHead), bytes.begin() + kHead);
  return bytes;
}

template <class Decode, class Encoded>
void expect_written_again(const Decode& decode, Encoded& bytes) {
  const auto packet = decode(bytes);
  if (!packet) return;
  Encoded again = bytes, twice = bytes;
  hw::fri::encode(*packet, again);
  const auto back = decode(again);
  test::demand(back.has_value(), "what was written can be read");
  hw::fri::encode(*back, twice);
  test::demand(again == twice, "what was read is written as it was");
}

/// A running arm that gets one datagram from its controller, and its controller one from the driver.
void disturb(Bytes to_driver, Bytes to_controller) {
  auto description = std::make_shared<const device::ArmDescription>(test::compliant_arm_description(hw::fri::kJoints));
  const auto machine = std::make_shared<test::FakeArm>(device::JointVector::Zero(hw::fri::kJoints));
  hw::fri::Twin twin({.device = "arm", .description = description}, {}, machine);
  device::ArmSample sample;
  for (int i = 0; i < 140; ++i) (void)twin.read(sample);
  twin.inject(to_driver, to_controller);
  for (int i = 0; i < 40; ++i) (void)twin.read(sample);
  for (const auto& told : machine->sent) {
    test::demand(told.q.allFinite() && told.dq.allFinite(), "an arm is told finite numbers");
    test::demand(told.q.cwiseAbs().maxCoeff() <= 3.0, "an arm stays inside its range");
  }
}

void load(std::string_view text) {
  const Bytes input = std::as_bytes(std::span(text));
  std::array<std::byte, kMeasurementSize> measurement{};
  std::array<std::byte, kCommandSize> command{};
  hw::fri::encode(hw::fri::Measurement{}, measurement);
  hw::fri::encode(hw::fri::Command{}, command);
  auto dressed_measurement = dressed(measurement, input);
  auto dressed_command = dressed(command, input);
  expect_written_again(hw::fri::decode_measurement, dressed_measurement);
  expect_written_again(hw::fri::decode_command, dressed_command);
  (void)hw::fri::decode_measurement(input);
  (void)hw::fri::decode_command(input);
  disturb(input, input);
  disturb(dressed_measurement, dressed_command);
}

}  // namespace
}  // namespace takt

namespace takt::test {

const FuzzTarget& fuzz_target() {
  static const FuzzTarget target{.words = {"MSR", "CMD"},
                                 .load = load,
                                 .share = 0.0,
                                 .mutate = [](std::string_view, Random&) -> std::optional<std::string> { return {}; }};
  return target;
}

}  // namespace takt::test
