#pragma once

#include <memory>
#include <string>

#include "hw/cia402/twin.h"
#include "tests/support/arm_rig.h"
#include "tests/support/fake_arm.h"

namespace takt::test {

/// An arm without a body behind emulated drives on a virtual bus, and the driver in front of them.
struct Cia402TwinRig final : ArmRig {
  explicit Cia402TwinRig(hw::cia402::TwinOptions options = {}, Nanoseconds cycle = 4 * kMillisecond, int joints = 3) {
    auto adapted = std::make_shared<device::ArmDescription>(fake_arm_description(joints));
    adapted->cycle = options.client.cycle = options.bus.cycle = cycle;
    adapted->sample_age_max = 20 * cycle;
    description = adapted;
    arm = std::make_shared<FakeArm>(device::JointVector::Zero(joints));
    tap = std::make_shared<ArmTap>(arm);
    twin = std::make_shared<hw::cia402::Twin>(
        device::DriverRequest{.device = "arm", .description = description, .seed = 11}, options, tap);
    backend = twin;
    pass_cycle = [this] { twin->pass_cycle(); };
    told_resolution = tracking = 1e-7;  // an increment is 6e-8 rad
    speed_noise = 1e-6;
    smoothness = 1.05 + 0.8 * to_seconds(cycle);
    if (options.faults.wire.loss > 0.0) smoothness = 2.0;
  }
  void release() override {
    arm->state().ready = true;
    twin->reset();
  }

  std::shared_ptr<FakeArm> arm;
  std::shared_ptr<hw::cia402::Twin> twin;
};

}  // namespace takt::test
