#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/device/arm.h"
#include "core/emulation/slow_arm.h"
#include "tests/support/fake_arm.h"

namespace takt::test {

/// Stands between a back end and what drives it, and keeps what was told.
class ArmTap final : public device::ArmBackend {
 public:
  explicit ArmTap(std::shared_ptr<device::ArmBackend> behind) : behind_(std::move(behind)) {}

  void set_held(bool held) override { behind_->set_held(held); }
  bool read(device::ArmSample& sample) override {
    if (silent || !behind_->read(sample)) return false;
    if (falsify) falsify(sample);
    return true;
  }
  void write(const device::ArmSetPoint& set_point) override {
    told.push_back(set_point);
    behind_->write(set_point);
  }
  void write_compliance(const device::Compliance& compliance) override { behind_->write_compliance(compliance); }
  void change_mode(device::ControlMode mode) override { behind_->change_mode(mode); }
  void set_payload(const device::PayloadSetting& payload) override { behind_->set_payload(payload); }
  void set_tool(const device::ToolSetting& tool) override { behind_->set_tool(tool); }
  void brake() override { behind_->brake(); }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return behind_->fault_text(fault); }
  [[nodiscard]] device::BackendTiming timing() const override { return behind_->timing(); }

  std::vector<device::ArmSetPoint> told;
  bool silent = false;
  std::function<void(device::ArmSample&)> falsify;  ///< what the machine does instead of following

 private:
  std::shared_ptr<device::ArmBackend> behind_;
};

/// An arm back end on the bench, as the conformance suite needs it: the machine, and what a person beside it does.
/// `backend` is what is tested; `tap` sees what the drives are told in each cycle, the last stage before the joints.
struct ArmRig {
  virtual ~ArmRig() = default;
  /// What the world does in a cycle after the set points were handed over.
  virtual void advance() {}
  /// A cycle in which the core does nothing, for those to which a core's read() is what makes time go on.
  std::function<void()> pass_cycle = [] {};
  /// What an operator does after brakes or a fault.
  virtual void release() = 0;

  std::shared_ptr<const device::ArmDescription> description;
  std::shared_ptr<device::ArmBackend> backend;
  std::shared_ptr<ArmTap> tap;
  double told_resolution = 1e-12;  ///< rad: in which the drives are told positions
  double tracking = 1e-9;          ///< rad: how far measured and told may lie apart
  double speed_noise = 1e-9;       ///< rad/s: of the measured velocity
  double smoothness =
      1.001;                 ///< share of the acceleration limit that the drives may be told, faults of a wire included
  bool has_mass = false;     ///< it has a body: set points act in the cycle after them
  bool weight_pulls = true;  ///< a wrong payload moves one with a body; false: a base, which does not carry upwards
};

/// A name for the tests, and how the arm is made: a hardware driver is one more line of these.
struct ArmUnderTest {
  std::string name;
  std::function<std::unique_ptr<ArmRig>()> make;
};

inline void PrintTo(const ArmUnderTest& arm, std::ostream* out) { *out << arm.name; }
inline std::string name_of_case(const testing::TestParamInfo<ArmUnderTest>& info) { return info.param.name; }

/// The arm without a body.
struct FakeArmRig final : ArmRig {
  FakeArmRig() {
    description = std::make_shared<const device::ArmDescription>(fake_arm_description(3));
    arm = std::make_shared<FakeArm>(device::JointVector::Zero(3));
    backend = tap = std::make_shared<ArmTap>(arm);
    pass_cycle = [this] {
      device::ArmSample ignored;
      (void)arm->read(ignored);
    };
  }
  void release() override { arm->state().ready = true; }

  std::shared_ptr<FakeArm> arm;
};

/// Any arm with a clock and a wire of its own around it.
inline std::unique_ptr<ArmRig> slowed(std::unique_ptr<ArmRig> rig, const emulation::SlowOptions& options) {
  auto adapted = std::make_shared<device::ArmDescription>(*rig->description);
  adapted->cycle = options.cycle;
  adapted->sample_age_max = 20 * options.cycle;
  rig->description = adapted;
  const auto slow = std::make_shared<emulation::SlowArm>("arm", rig->tap, adapted->limits, options, kMillisecond, 11);
  rig->backend = slow;
  rig->pass_cycle = [slow] { slow->pass_cycle(); };
  // Losses are bridged by extrapolation, and the way back costs acceleration.
  const bool faulty = options.wire.loss > 0.0 || options.wire.reorder > 0.0;
  rig->smoothness = faulty ? 2.0 : 1.02 + 0.8 * to_seconds(options.cycle);
  return rig;
}

}  // namespace takt::test
