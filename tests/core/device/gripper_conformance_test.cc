// A gripper without a body, under the suite that every gripper must pass.
#include "tests/support/gripper_conformance.h"

#include "tests/support/fake_signals.h"
#include "tests/support/kinematic_gripper.h"

namespace takt::test {
namespace {

class KinematicRig final : public GripperRig {
 public:
  explicit KinematicRig(bool with_part) {
    description = std::make_shared<const device::GripperDescription>(fake_gripper_description());
    part_width = with_part ? 0.04 : 0.0;
    machine_ = std::make_shared<KinematicGripper>(description->stroke, part_width);
    backend = machine_;
  }
  void advance() override { machine_->advance(); }

 private:
  std::shared_ptr<KinematicGripper> machine_;
};

INSTANTIATE_TEST_SUITE_P(Fake, GripperConformance,
                         testing::Values(GripperUnderTest{
                             "Kinematic", [](bool part) { return std::make_unique<KinematicRig>(part); }}),
                         name_of_gripper);

}  // namespace
}  // namespace takt::test
