#include "core/operations/online/control_mode.h"

#include <utility>
#include <vector>

#include "core/activity/mode_change.h"
#include "core/operations/table/scheduled_run.h"

namespace takt::operations {
namespace {

class ControlModeRun final : public ScheduledRun {
 public:
  explicit ControlModeRun(const ControlModeParameters& parameters) : parameters_(parameters) {}

 private:
  [[nodiscard]] activity::ActivityPtr activity(activity::Context&) override {
    return activity::mode_activity(parameters_.arm, parameters_.mode);
  }

  const ControlModeParameters& parameters_;
};

class ControlModeStep final : public Step {
 public:
  explicit ControlModeStep(ControlModeParameters parameters) : parameters_(std::move(parameters)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    const device::Arm* arm = rehearsal.cell.arms.at(parameters_.arm).device;
    if (arm == nullptr) return;  // only names are known
    const auto is = rehearsal.modes.find(parameters_.arm);
    diagnostics.append(activity::check_mode_change(*arm, is != rehearsal.modes.end() ? is->second : parameters_.mode,
                                                   parameters_.mode),
                       pointer);
    rehearsal.modes[parameters_.arm] = parameters_.mode;
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override {
    return std::make_unique<ControlModeRun>(parameters_);
  }

 private:
  ControlModeParameters parameters_;
};

}  // namespace

const ParameterTable<ControlModeParameters>& control_mode_parameters() {
  static const auto table = [] {
    std::vector<std::pair<std::string, device::ControlMode>> modes;
    for (const device::ControlMode mode : device::all_control_modes()) modes.emplace_back(name_of(mode), mode);
    ParameterTable<ControlModeParameters> change;
    change.name("arm", NameOf::kArm, &ControlModeParameters::arm, "Arm whose mode changes; nothing may hold it.")
        .choice("mode", &ControlModeParameters::mode, modes, "The new control mode.")
        .required();
    return change;
  }();
  return table;
}

Operation control_mode_operation() {
  return {.name = "control_mode",
          .doc = "Brings an arm into a control mode while nothing holds it.",
          .parameters = rows_of<control_mode_parameters>,
          .read_step = read_step<ControlModeStep, control_mode_parameters>};
}

}  // namespace takt::operations
