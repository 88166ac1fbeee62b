// The driver and the emulated controller, over a virtual wire, under the suite that every arm must pass.
#include "tests/support/arm_conformance.h"

#include <random>

#include "hw/rtde/kind/lock_step_robot.h"
#include "hw/wire/posix_network.h"
#include "tests/hw/rtde/controller_bench.h"
#include "tests/hw/rtde/log_rig.h"

namespace takt::test {
namespace {

/// Driver, wire and controller around an arm without a body.
struct RtdeRig final : ArmRig {
  RtdeRig(const hw::rtde::DriverOptions& options, const hw::rtde::ControllerOptions& controller,
          const hw::VirtualFaults& faults, const emulation::DeviceClock& clock, bool on_sockets) {
    static hw::PosixNetwork sockets;
    auto adapted = std::make_shared<device::ArmDescription>(*ur5());
    adapted->cycle = options.cycle();
    adapted->sample_age_max = 20 * options.cycle();
    description = adapted;
    tap = std::make_shared<ArmTap>(std::make_shared<FakeArm>(ur5()->home));
    const device::DriverRequest request{.device = "arm", .description = description, .seed = 11};
    robot = std::make_shared<hw::rtde::LockStepRobot>(options, controller, request, tap, faults, clock,
                                                      on_sockets ? &sockets : nullptr);
    EXPECT_TRUE(robot->begin());
    backend = robot;
    pass_cycle = [this] { robot->pass_cycle(); };
    // The controller makes velocities and accelerations of the positions of three cycles: where the jerk switches
    // between them, the way from one to the next costs more acceleration.
    smoothness = 1.02 + 7.0 * to_seconds(options.cycle());
    tracking = 1e-6;
    speed_noise = 1e-3;
  }
  /// Somebody powers the robot on again and resets the driver.
  void release() override {
    robot->robot().controller().power().release_brakes();
    robot->reset();
  }

  std::shared_ptr<hw::rtde::LockStepRobot> robot;
};

ArmUnderTest over(const std::string& name, const hw::rtde::DriverOptions& options,
                  const hw::rtde::ControllerOptions& controller, const hw::VirtualFaults& faults,
                  const emulation::DeviceClock& clock, bool on_sockets = false) {
  return {name, [=] { return std::make_unique<RtdeRig>(options, controller, faults, clock, on_sockets); }};
}

const hw::rtde::DriverOptions kCb3, kE{.e_series = true};
// Ports are fixed, so the address is drawn: runs side by side do not meet.
const hw::rtde::DriverOptions kLoopback{.host = 0x7f00'0001u | ((std::random_device{}() & 0xffffU) << 8)};
const hw::VirtualFaults kWire{.wire = {.transport = 100'000, .jitter = 300'000}};
const hw::VirtualFaults kPieces{.wire = {.transport = 100'000, .jitter = 300'000}, .stream_piece = 7};

/// What was written down of a test is played to a second driver, which has to do the same to the bit.
ArmUnderTest on_a_log(const std::string& name, const hw::rtde::DriverOptions& options,
                      const hw::rtde::ControllerOptions& controller, const hw::VirtualFaults& faults) {
  return {name, [=] { return std::make_unique<RtdeLogRig>(options, controller, faults); }};
}

INSTANTIATE_TEST_SUITE_P(RtdeLog, ArmConformance,
                         testing::Values(on_a_log("Recorded", kCb3, {}, kWire),
                                         on_a_log("RecordedInPieces", kE, e_series(), kPieces)),
                         name_of_case);

INSTANTIATE_TEST_SUITE_P(Rtde, ArmConformance,
                         testing::Values(over("Cb3", kCb3, {}, kWire, {5 * kSecond + 123, 100e-6}),
                                         over("Cb3InPieces", kCb3, {}, kPieces, {0, -100e-6}),
                                         over("ESeries", kE, e_series(), kWire, {kSecond, 50e-6}),
                                         over("Cb3OverSockets", kLoopback, {}, {}, {}, true)),
                         name_of_case);

}  // namespace
}  // namespace takt::test
