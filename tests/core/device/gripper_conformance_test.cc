// A gripper without a body, under the suite that every gripper must pass.
#include "tests/support/gripper_conformance.h"

#include "tests/support/fake_signals.h"

namespace takt::test {
namespace {

/// Fingers that go where they are told, with the speed they are told, until they meet the part.
class KinematicGripper final : public device::GripperBackend {
 public:
  KinematicGripper(double width, double part) : part_(part) {
    sample_.width = width;
    sample_.ready = true;
  }
  bool read(device::GripperSample& out) override {
    out = sample_;
    return sample_.sequence > 0;
  }
  void write(const device::GripperSetPoint& set_point) override {
    if (set_point.sequence == command_.sequence) return;
    command_ = set_point;
    sample_.state = device::GripperState::kMoving;
  }
  void advance() {
    ++sample_.sequence;
    sample_.stamp += kMillisecond;
    sample_.command = command_.sequence;
    if (sample_.state != device::GripperState::kMoving) return;
    const double step = command_.speed * 1e-3, way = command_.width - sample_.width;
    sample_.width += std::clamp(way, -step, step);
    const bool met = part_ > 0.0 && way < 0.0 && sample_.width <= part_;
    if (met) sample_.width = part_;
    sample_.force = met ? command_.force : 0.0;
    if (met) sample_.state = device::GripperState::kHolding;
    if (!met && std::abs(way) <= step) sample_.state = device::GripperState::kIdle;
  }

 private:
  double part_;
  device::GripperSetPoint command_;
  device::GripperSample sample_;
};

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
