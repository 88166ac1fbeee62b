// The driver for drives of CiA 402 in front of emulated ones, in process and in virtual time, under the suite that
// every arm must pass.
#include "tests/support/arm_conformance.h"
#include "tests/hw/cia402/log_rig.h"
#include "tests/hw/cia402/twin_rig.h"

namespace takt::test {
namespace {

using hw::cia402::TwinOptions;

ArmUnderTest drives(const std::string& name, const TwinOptions& options, Nanoseconds cycle, int joints = 3) {
  return {name, [=] { return std::make_unique<Cia402TwinRig>(options, cycle, joints); }};
}

TwinOptions on_a_bus(Nanoseconds jitter, double loss) {
  TwinOptions options;
  options.faults.wire = {.transport = 50'000, .jitter = jitter, .loss = loss};
  options.client.margin = jitter;
  return options;
}

/// What was written down of a test is played to a second driver, which has to do the same to the bit.
ArmUnderTest on_a_log(const std::string& name, const hw::VirtualFaults& faults, Nanoseconds cycle) {
  return {name, [=] { return std::make_unique<DrivesLogRig>(faults, cycle); }};
}

const hw::VirtualFaults kIdealBus{.wire = {.transport = 50'000}};
const hw::VirtualFaults kBadBus{.wire = {.transport = 50'000, .jitter = 200'000, .loss = 0.002}};

INSTANTIATE_TEST_SUITE_P(Cia402Log, ArmConformance,
                         testing::Values(on_a_log("Recorded", kIdealBus, 4 * kMillisecond),
                                         on_a_log("RecordedWithLosses", kBadBus, 2 * kMillisecond)),
                         name_of_case);

INSTANTIATE_TEST_SUITE_P(Cia402Twin, ArmConformance,
                         testing::Values(drives("Ideal", {}, 4 * kMillisecond),
                                         drives("1ms", on_a_bus(0, 0.0), kMillisecond),
                                         drives("4msWithJitter", on_a_bus(200'000, 0.0), 4 * kMillisecond),
                                         drives("2msWithLosses", on_a_bus(0, 0.002), 2 * kMillisecond),
                                         drives("8msSevenJoints", on_a_bus(0, 0.0), 8 * kMillisecond, 7)),
                         name_of_case);

}  // namespace
}  // namespace takt::test
