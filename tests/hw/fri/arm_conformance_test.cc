// The FRI driver in front of an emulated controller, in process and in virtual time, under the suite that every arm
// must pass.
#include "tests/support/arm_conformance.h"
#include "tests/hw/fri/log_rig.h"
#include "tests/hw/fri/socket_rig.h"
#include "tests/hw/fri/twin_rig.h"

namespace takt::test {
namespace {

using hw::fri::TwinOptions;

ArmUnderTest twin(const std::string& name, const TwinOptions& options) {
  return {name, [options] { return std::make_unique<FriTwinRig>(options); }};
}

TwinOptions with_cycle(Nanoseconds cycle) {
  TwinOptions options;
  options.clock_offset = 3 * kSecond + 123'456;
  options.drift = 100e-6;
  options.client.cycle = options.controller.cycle = cycle;
  options.faults.wire.transport = 100'000;
  return options;
}

TwinOptions with_jitter() {
  TwinOptions options = with_cycle(kMillisecond);
  options.faults.wire.jitter = options.client.margin = 300'000;
  return options;
}

TwinOptions with_losses() {
  TwinOptions options = with_cycle(2 * kMillisecond);
  options.client.margin = 300'000;
  options.faults.wire = {
      .transport = 100'000, .jitter = 300'000, .loss = 0.01, .repeat = 0.02, .reorder = 0.01, .hold_back = 3'500'000};
  return options;
}

TwinOptions with_krl(const std::string& convention) {
  TwinOptions options = with_cycle(kMillisecond);
  options.client.krl = options.controller.krl = convention;
  return options;
}

/// What was written down of a test is played to a second driver, which has to do the same to the bit.
ArmUnderTest on_a_log(const std::string& name, const hw::VirtualFaults& faults) {
  return {name, [faults] { return std::make_unique<FriLogRig>(faults); }};
}

const hw::VirtualFaults kIdealWire{.wire = {.transport = 100'000}};
const hw::VirtualFaults kBadWire{.wire = {.transport = 100'000,
                                          .jitter = 300'000,
                                          .loss = 0.01,
                                          .repeat = 0.02,
                                          .reorder = 0.01,
                                          .hold_back = 1'500'000}};

INSTANTIATE_TEST_SUITE_P(FriLog, ArmConformance,
                         testing::Values(on_a_log("Recorded", kIdealWire), on_a_log("RecordedWithLosses", kBadWire)),
                         name_of_case);

INSTANTIATE_TEST_SUITE_P(FriTwin, ArmConformance,
                         testing::Values(twin("Ideal", {}), twin("1ms", with_cycle(kMillisecond)),
                                         twin("4ms", with_cycle(4 * kMillisecond)),
                                         twin("1msWithJitter", with_jitter()), twin("2msWithLosses", with_losses()),
                                         twin("KrlFriControl", with_krl("fri_control")),
                                         twin("KrlRosControl", with_krl("ros_control")),
                                         ArmUnderTest{"Sockets", [] { return std::make_unique<FriSocketRig>(); }}),
                         name_of_case);

}  // namespace
}  // namespace takt::test
