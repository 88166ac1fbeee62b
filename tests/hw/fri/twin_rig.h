#pragma once

#include <memory>
#include <string>

#include "hw/fri/twin.h"
#include "tests/support/arm_rig.h"
#include "tests/support/fake_arm.h"

namespace takt::test {

/// A seven-joint arm without a body behind an emulated controller, and the driver in front of it, in virtual time.
struct FriTwinRig final : ArmRig {
  explicit FriTwinRig(const hw::fri::TwinOptions& options = {}, std::uint64_t seed = 11) {
    auto adapted = std::make_shared<device::ArmDescription>(compliant_arm_description(hw::fri::kJoints));
    adapted->cycle = options.client.cycle;
    for (auto& change : adapted->modes.changes) change.duration = 500 * kMillisecond;  // through monitor state and back
    adapted->sample_age_max = 20 * options.client.cycle;
    description = adapted;
    arm = std::make_shared<FakeArm>(device::JointVector::Zero(hw::fri::kJoints));
    tap = std::make_shared<ArmTap>(arm);
    twin = std::make_shared<hw::fri::Twin>(
        device::DriverRequest{.device = "arm", .description = description, .seed = seed}, options, tap);
    backend = twin;
    pass_cycle = [this] { twin->pass_cycle(); };
    // Positions are of binary32 on the wire: four roundings of pi in a second difference over a millisecond.
    told_resolution = 3e-7;
    smoothness = 1.08 + 0.8 * to_seconds(options.client.cycle);
    speed_noise = 1e-3;
    tracking = 3e-7;
    const auto& wire = options.faults.wire;
    if (wire.loss > 0.0 || wire.reorder > 0.0) smoothness = 2.0;
  }
  void release() override {
    arm->state().ready = true;
    twin->reset();
  }

  std::shared_ptr<FakeArm> arm;
  std::shared_ptr<hw::fri::Twin> twin;
};

}  // namespace takt::test
