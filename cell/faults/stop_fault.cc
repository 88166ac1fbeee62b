// Faults "stop", "release", "emergency_stop", "reset": of the arms, and of a person at the cabinet.
#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "cell/build/site_devices.h"
#include "cell/faults/fault_kinds.h"
#include "core/base/keys_of.h"

namespace takt::cell {
namespace {

constexpr const char* kLatchName = "emergency_stop";

Key category_key() {
  return integer_key("category", {.low = 0, .high = 2},
                     "Stop category: 0 closes the brakes at once, 1 after a controlled stop, 2 is held by the drives "
                     "after one (docs/devices/arm.md).")
      .by_default(1.0);
}

Key affected_arm_key() { return text_key("arm", "Arm that is affected.").optional("all"); }

device::StopCategory read_category(FaultReader& from) {
  return static_cast<device::StopCategory>(from.integer("category"));
}

/// Of the arms that are affected.
template <class Do>
void for_each_arm(FaultScene& scene, const std::string& name, const Do& act) {
  for (const auto& [arm, state] : scene.built.cell.arms)
    if (name.empty() || name == arm) act(arm, *scene.built.world->arm(arm));
}

void release(FaultScene& scene, const std::string& name) {
  for_each_arm(scene, name, [&](const std::string& arm, sim::SimArm& machine) {
    machine.release_brakes();
    if (scene.built.site) scene.built.site->reset(arm);
  });
}

class StopFault final : public Fault {
 public:
  explicit StopFault(FaultReader& from)
      : arm_(from.device("arm", "arm", keys_of(from.built.cell.arms))), category_(read_category(from)) {}
  void begin(FaultScene& scene) override {
    scene.note("stop", fmt::format("{} category {}", arm_, static_cast<int>(category_)));
    for_each_arm(scene, arm_, [this](const std::string&, sim::SimArm& machine) { machine.stop(category_); });
  }

 private:
  std::string arm_;
  device::StopCategory category_;
};

class ReleaseFault final : public Fault {
 public:
  explicit ReleaseFault(FaultReader& from) : arm_(from.device("arm", "arm", keys_of(from.built.cell.arms))) {}
  void begin(FaultScene& scene) override {
    scene.note("release", arm_);
    release(scene, arm_);
  }

 private:
  std::string arm_;
};

/// Gives the cell the latch behind its button, once.
void install_latch(FaultReader& from) {
  BuiltCell& built = from.built;
  if (built.emergency_stop != nullptr) return;
  if (built.core->environment().find(kLatchName) != nullptr) {
    from.diagnostics().error(Code::kDuplicate, from.pointer(), fmt::format("a device is called '{}'", kLatchName),
                             "Choose another name for it");
    return;
  }
  built.emergency_stop = &built.core->add(std::make_unique<device::EmergencyStop>(kLatchName));
  built.emergency_stop->set_healthy(true);
}

class EmergencyStopFault final : public Fault {
 public:
  explicit EmergencyStopFault(FaultReader& from)
      : category_(read_category(from)), brakes_after_(from.time("brakes_after_s")) {
    if (from.has("brakes_after_s") && category_ != device::StopCategory::kStopThenBrakes)
      from.diagnostics().error(Code::kConflict, from.at("brakes_after_s"), "nothing waits here",
                               "Remove it, or set category 1");
    install_latch(from);
  }
  void begin(FaultScene& scene) override {
    scene.note("emergency_stop", fmt::format("category {}", static_cast<int>(category_)));
    scene.circuit.press(category_, brakes_after_);
  }

 private:
  device::StopCategory category_;
  Nanoseconds brakes_after_;
};

class ResetFault final : public Fault {
 public:
  explicit ResetFault(FaultReader&) {}
  void begin(FaultScene& scene) override {
    scene.note("reset", "");
    release(scene, "");
    scene.circuit.reset();
  }
};

}  // namespace

FaultKind stop_fault() {
  return fault_kind<StopFault>("stop", Concerns::kMachine,
                               {"The arm stops by itself.", {affected_arm_key(), category_key()}});
}

FaultKind release_fault() {
  return fault_kind<ReleaseFault>(
      "release", Concerns::kMachine,
      {"A person acknowledges the fault of an arm and opens its brakes.", {affected_arm_key()}});
}

FaultKind emergency_stop_fault() {
  return fault_kind<EmergencyStopFault>(
      "emergency_stop", Concerns::kCore,
      {"The button is pressed: it concerns all arms.",
       {category_key(), number_key("brakes_after_s", "s", {.low = 0.0, .high = 60.0},
                                   "With category 1: delay after which a separate circuit closes the brakes, "
                                   "whatever the core does.")
                            .by_default(1.0)}});
}

FaultKind reset_fault() {
  return fault_kind<ResetFault>("reset", Concerns::kCore,
                                {"The button is pulled, the latch is reset and all arms are released."});
}

}  // namespace takt::cell
