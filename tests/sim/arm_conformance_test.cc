// The MuJoCo arm, or base, of each model, direct and slow, under the suite that every arm must pass.
#include "tests/support/arm_conformance.h"

#include <algorithm>

#include "core/device/base_description.h"
#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "sim/world/world.h"

namespace takt::test {
namespace {

using emulation::SlowOptions;

/// An arm of a model, alone in a world, standing at its home.
class SimArmRig final : public ArmRig {
 public:
  explicit SimArmRig(const std::string& model, device::ControlMode mode = device::ControlMode::kPosition) {
    sim::WorldDescription world_description;
    if (!read(model, world_description)) return;
    world_description.robots.push_back(sim::arm_body("arm", *description, {}));
    // The first mode is the one after power-on. Springs lag behind what moves them, by friction and more.
    auto& modes = world_description.arms.back().control.modes.modes;
    std::ranges::rotate(modes, std::ranges::find(modes, mode));
    auto made = sim::World::create(world_description);
    if (!made) {
      ADD_FAILURE() << made.error().to_string();
      return;
    }
    world = std::make_shared<sim::World>(std::move(*made));
    backend = tap = std::make_shared<ArmTap>(std::shared_ptr<device::ArmBackend>(world, world->arm("arm")));
    has_mass = true;
    // The position controller leans on its gains: what friction it does not know costs. The TX90 has the most.
    const bool stiff = mode == device::ControlMode::kPosition;
    tracking = stiff ? 1.2e-3 : 5e-3;
    speed_noise = stiff ? 1e-2 : 5e-2;
    EXPECT_EQ(world->arm("arm")->mode(), mode);
  }

  void advance() override { ASSERT_TRUE(world->step()); }
  void release() override { world->arm("arm")->release_brakes(); }

 private:
  /// An arm, or a base, which has to pass as one.
  bool read(const std::string& model, sim::WorldDescription& into) {
    const std::string folder = "models/" + model;
    if (device::read_device_kind(folder).value_or("") == "base") {
      const auto base = device::read_base(folder);
      if (!base) return fail(base.error());
      into.arms.push_back(sim::simulated_base("arm", "arm", **base));
      description = *base;
      weight_pulls = false;
    } else {
      const auto arm = device::read_arm(folder);
      if (!arm) return fail(arm.error());
      into.arms.push_back(sim::simulated_arm("arm", "arm", **arm));
      description = *arm;
    }
    return true;
  }
  static bool fail(const Diagnostics& diagnostics) {
    ADD_FAILURE() << diagnostics.to_string();
    return false;
  }

  std::shared_ptr<sim::World> world;
};

ArmUnderTest direct(const std::string& model) {
  return {model, [model] { return std::make_unique<SimArmRig>(model); }};
}
ArmUnderTest compliant(const std::string& model, device::ControlMode mode) {
  const std::string how = mode == device::ControlMode::kJointImpedance ? "JointImpedance" : "CartesianImpedance";
  return {model + how, [=] { return std::make_unique<SimArmRig>(model, mode); }};
}
ArmUnderTest slow(const std::string& model, const std::string& how, const SlowOptions& options) {
  return {model + how, [=] { return slowed(std::make_unique<SimArmRig>(model), options); }};
}

const SlowOptions k8ms{.cycle = 8 * kMillisecond,
                       .clock_offset = 5 * kSecond + 123,
                       .drift = 100e-6,
                       .wire = {.transport = 100'000, .jitter = 300'000}};
const SlowOptions k4ms{.cycle = 4 * kMillisecond,
                       .clock_offset = -kSecond,
                       .drift = -100e-6,
                       .wire = {.transport = 100'000,
                                .jitter = 300'000,
                                .loss = 0.01,
                                .repeat = 0.01,
                                .reorder = 0.01,
                                .hold_back = 6 * kMillisecond}};
const SlowOptions k1ms{.cycle = kMillisecond, .drift = 100e-6, .wire = {.transport = 50'000, .jitter = 300'000}};

INSTANTIATE_TEST_SUITE_P(MuJoCo, ArmConformance,
                         testing::Values(direct("lwr4plus"), direct("ur5"), direct("tx90"), direct("youbot_base"),
                                         compliant("lwr4plus", device::ControlMode::kJointImpedance),
                                         compliant("lwr4plus", device::ControlMode::kCartesianImpedance),
                                         slow("lwr4plus", "Slow1ms", k1ms), slow("lwr4plus", "Slow8ms", k8ms),
                                         slow("ur5", "Slow8ms", k8ms), slow("youbot_base", "Slow8ms", k8ms),
                                         slow("tx90", "Slow4msWithLosses", k4ms)),
                         name_of_case);

}  // namespace
}  // namespace takt::test
