// Faults "stop", "release", "emergency_stop" and "reset": arms that stop, the button of a cabinet, and who deals with
// them.
#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "scenario/cell_builder.h"
#include "scenario/fault.h"

namespace takt::scenario {
namespace {

constexpr const char* kLatchName = "emergency_stop";

using device::StopCategory;

/// A fault of one arm, or of all.
class ArmsFault : public Fault {
 public:
  void add_to(BuiltCell& built, Diagnostics& diagnostics) const override {
    if (arm.empty() || built.cell.arms.contains(arm)) return;
    std::vector<std::string> arms;
    for (const auto& [name, one] : built.cell.arms) arms.push_back(name);
    diagnostics.error(Code::kUnknownName, pointer + "/arm", fmt::format("there is no arm '{}'", arm),
                      nearest_choice(arm, arms));
  }

  std::string arm = {};  ///< empty: all

 protected:
  template <class Act>
  void for_each_arm(FaultContext& context, const Act& act) const {
    for (const auto& [name, device] : context.built.cell.arms)
      if (arm.empty() || arm == name) act(*context.built.world->arm(name));
  }
};

class StopFault final : public ArmsFault {
 public:
  void begin(FaultContext& context) const override {
    note(context, fmt::format("{} category {}", arm, static_cast<int>(category)));
    for_each_arm(context, [&](sim::SimArm& machine) { machine.stop(category); });
  }

  StopCategory category = StopCategory::kStopThenBrakes;
};

class ReleaseFault final : public ArmsFault {
 public:
  void begin(FaultContext& context) const override {
    note(context, arm);
    for_each_arm(context, [](sim::SimArm& machine) { machine.release_brakes(); });
  }
};

/// The core leads the arms to rest; a circuit beside it sees to their brakes.
class EmergencyStopFault final : public Fault {
 public:
  void add_to(BuiltCell& built, Diagnostics& diagnostics) const override {
    if (built.emergency_stop != nullptr) return;
    if (built.core->environment().find(kLatchName) != nullptr)
      return diagnostics.error(Code::kDuplicate, "/faults", fmt::format("a device is called '{}'", kLatchName),
                               "Give it another name");
    built.emergency_stop = &built.core->add(std::make_unique<device::EmergencyStop>(kLatchName));
    built.emergency_stop->set_healthy(true);
  }
  void begin(FaultContext& context) const override {
    note(context, fmt::format(" category {}", static_cast<int>(category)));
    context.built.emergency_stop->set_category(category);
    context.built.emergency_stop->set_healthy(false);
    if (category == StopCategory::kBrakes) context.button.brakes_at = context.now;
    if (category == StopCategory::kStopThenBrakes) context.button.brakes_at = context.now + brakes_after;
  }

  StopCategory category = StopCategory::kStopThenBrakes;
  Nanoseconds brakes_after = kSecond;
};

class ResetFault final : public Fault {
 public:
  void add_to(BuiltCell&, Diagnostics&) const override {}
  void begin(FaultContext& context) const override {
    note(context, "");
    for (const auto& [name, arm] : context.built.cell.arms) context.built.world->arm(name)->release_brakes();
    if (context.built.emergency_stop == nullptr) return;
    context.button.brakes_at.reset();
    context.built.emergency_stop->set_healthy(true);
    context.button.reset_pending = true;
  }
};

template <class F>
void add_arm(table::Table<F>& table) {
  table.named("arm", table::NameOf::kArm, &F::arm, "Arm that is affected.").fallback("all");
}

table::ValueType<StopCategory> category_type() {
  table::ValueType<StopCategory> type{.info = table::integer_type({.low = 0, .high = 2}).info};
  type.read = [](const table::Field& row, ObjectReader& reader, const std::optional<StopCategory>& fallback) {
    return static_cast<StopCategory>(reader.integer(row.key, static_cast<int>(*fallback), row.range));
  };
  type.write = [](const table::Field& row, const StopCategory& category, table::Writer& to) {
    to.integer(row.key, static_cast<int>(category));
  };
  type.text = [](const StopCategory& category) { return std::to_string(static_cast<int>(category)); };
  return type;
}

/// The button concerns all arms.
template <class F>
void refuse_arm(table::Table<F>& table) {
  table.refuse("arm", "an emergency stop concerns all arms", "Remove 'arm', or set \"do\": \"stop\"");
}

template <class F>
void add_category(table::Table<F>& table) {
  table.value(
      "category", category_type(), &F::category,
      "Stop category: 0 closes the brakes at once, 1 after a controlled stop, 2 is held by the drives after one "
      "(docs/devices/arm.md).");
}

const table::Table<StopFault>& stop_table() {
  static const auto table = [] {
    table::Table<StopFault> stop;
    add_arm(stop);
    add_category(stop);
    return stop;
  }();
  return table;
}

const table::Table<ReleaseFault>& release_table() {
  static const auto table = [] {
    table::Table<ReleaseFault> release;
    add_arm(release);
    return release;
  }();
  return table;
}

const table::Table<EmergencyStopFault>& emergency_stop_table() {
  static const auto table = [] {
    table::Table<EmergencyStopFault> stop;
    refuse_arm(stop);
    add_category(stop);
    stop.value("brakes_after_s", table::seconds_type({.low = 0.0, .high = 60.0}), &EmergencyStopFault::brakes_after,
               "Of category 1: delay after which a separate circuit closes the brakes, whatever the core does.")
        .rule([](EmergencyStopFault& fault, const table::Context& from) {
          if (from.reader.has("brakes_after_s") && fault.category != StopCategory::kStopThenBrakes)
            from.reader.diagnostics().error(Code::kConflict, from.reader.at("brakes_after_s"),
                                            "'brakes_after_s' applies only to category 1",
                                            "Remove it, or set \"category\": 1");
        });
    return stop;
  }();
  return table;
}

const table::Table<ResetFault>& reset_table() {
  static const auto table = [] {
    table::Table<ResetFault> reset;
    refuse_arm(reset);
    return reset;
  }();
  return table;
}

}  // namespace

FaultKind stop_fault() { return fault_kind<StopFault, stop_table>("stop", "The arm stops by itself."); }
FaultKind release_fault() {
  return fault_kind<ReleaseFault, release_table>("release",
                                                 "A person acknowledges the fault of an arm and opens its brakes.");
}
FaultKind emergency_stop_fault() {
  return fault_kind<EmergencyStopFault, emergency_stop_table>("emergency_stop",
                                                              "The button is pressed: it concerns all arms.");
}
FaultKind reset_fault() {
  return fault_kind<ResetFault, reset_table>("reset",
                                             "The button is pulled, the latch is reset and all arms are released.");
}

}  // namespace takt::scenario
