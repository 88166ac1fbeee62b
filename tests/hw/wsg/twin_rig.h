#pragma once

#include <memory>
#include <string>

#include "hw/wsg/twin.h"
#include "tests/support/fake_signals.h"
#include "tests/support/gripper_conformance.h"
#include "tests/support/kinematic_gripper.h"

namespace takt::hw::wsg {

inline TwinOptions ideal_wire() {
  TwinOptions options;
  options.faults.wire.transport = kMillisecond / 10;
  return options;
}

/// A kinematic gripper behind an emulated WSG, behind the driver, in virtual time.
class TwinRig final : public test::GripperRig {
 public:
  static constexpr double kPart = 0.04;  // m

  explicit TwinRig(bool with_part, TwinOptions options = ideal_wire(), std::uint64_t seed = 1) {
    description = std::make_shared<const device::GripperDescription>(test::fake_gripper_description());
    part_width = with_part ? kPart : 0.0;
    machine = std::make_shared<test::KinematicGripper>(description->stroke, part_width);
    twin = std::make_shared<Twin>(device::GripperRequest{"gripper", description, kMillisecond, seed}, options, machine);
    if (!twin->begin()) throw std::runtime_error("no port");
    backend = twin;
  }
  void advance() override { machine->advance(); }

  std::shared_ptr<test::KinematicGripper> machine;
  std::shared_ptr<Twin> twin;
};

}  // namespace takt::hw::wsg
