// The arm without a body and slow devices around it, under the suite that every arm must pass.
#include "tests/support/arm_conformance.h"

namespace takt::test {
namespace {

using emulation::SlowOptions;

ArmUnderTest slow_fake(const std::string& name, const SlowOptions& options) {
  return {name, [options] { return slowed(std::make_unique<FakeArmRig>(), options); }};
}

constexpr Nanoseconds kUs = 1000;

INSTANTIATE_TEST_SUITE_P(
    Fake, ArmConformance,
    testing::Values(
        ArmUnderTest{"Direct", [] { return std::make_unique<FakeArmRig>(); }},
        slow_fake("Slow1ms", {.cycle = kMillisecond}),
        slow_fake("Slow4ms", {.cycle = 4 * kMillisecond, .clock_offset = 123'456'789, .drift = -100e-6}),
        slow_fake("Slow8ms", {.cycle = 8 * kMillisecond, .clock_offset = -77 * kSecond - 1, .drift = 100e-6}),
        slow_fake("Slow8msWithJitter", {.cycle = 8 * kMillisecond,
                                        .clock_offset = 3 * kSecond,
                                        .drift = 100e-6,
                                        .wire = {.transport = 200 * kUs, .jitter = 800 * kUs}}),
        slow_fake("Slow1msWithJitter",
                  {.cycle = kMillisecond, .drift = 100e-6, .wire = {.transport = 50 * kUs, .jitter = 300 * kUs}}),
        slow_fake("Slow4msWithLosses", {.cycle = 4 * kMillisecond,
                                        .drift = -50e-6,
                                        .wire = {.transport = 100 * kUs,
                                                 .jitter = 300 * kUs,
                                                 .loss = 0.01,
                                                 .repeat = 0.02,
                                                 .reorder = 0.01,
                                                 .hold_back = 5 * kMillisecond}}),
        slow_fake("Slow100ms", {.cycle = 100 * kMillisecond, .drift = 100e-6})),
    name_of_case);

}  // namespace
}  // namespace takt::test
