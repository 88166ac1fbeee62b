// The sensor without a body and slow sensors around it, under the suite that every sensor must pass.
#include "tests/support/force_torque_conformance.h"

namespace takt::test {
namespace {

using emulation::SlowOptions;

SensorUnderTest slow_fake_sensor(const std::string& name, const SlowOptions& options) {
  return {name, [options] { return slowed(std::make_unique<FakeForceTorqueRig>(), options); }};
}

INSTANTIATE_TEST_SUITE_P(
    Fake, ForceTorqueConformance,
    testing::Values(SensorUnderTest{"Direct", [] { return std::make_unique<FakeForceTorqueRig>(); }},
                    slow_fake_sensor("Slow1ms", {.cycle = kMillisecond, .drift = 100e-6}),
                    slow_fake_sensor("Slow4ms", {.cycle = 4 * kMillisecond,
                                                 .clock_offset = -3 * kSecond,
                                                 .drift = -100e-6,
                                                 .wire = {.transport = 100'000, .jitter = 900'000}}),
                    slow_fake_sensor("Slow8ms", {.cycle = 8 * kMillisecond, .clock_offset = 77, .drift = 100e-6}),
                    slow_fake_sensor("Slow4msWithLosses", {.cycle = 4 * kMillisecond,
                                                           .drift = 50e-6,
                                                           .wire = {.jitter = 300'000,
                                                                    .loss = 0.02,
                                                                    .repeat = 0.02,
                                                                    .reorder = 0.02,
                                                                    .hold_back = 6 * kMillisecond}})),
    name_of_sensor);

}  // namespace
}  // namespace takt::test
