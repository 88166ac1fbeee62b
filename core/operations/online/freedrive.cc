#include "core/operations/online/freedrive.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/activity/activity_run.h"
#include "core/activity/dual_entry_motion.h"
#include "core/activity/motion_options.h"
#include "core/command/actions/freedrive_action.h"
#include "core/command/mapping.h"
#include "core/expression/condition_state.h"
#include "core/expression/device_sensors.h"
#include "core/operations/table/rehearsed_net.h"
#include "core/operations/table/scheduled_run.h"

namespace takt::operations {
namespace {

using expression::State;

/// Unknown whether it is paused means that it is. Never null.
State not_paused(const expression::Cell& cell, const std::string& channel) {
  const auto speed = expression::channel<net::Real>(cell, channel);
  return !is_null(speed) && is_greater(speed, 0.0);
}

/// While the motions of the arm are paused, by the program or by the operator, it does not yield.
command::GuidanceParameters guidance_of(const FreedriveParameters& parameters, const expression::Cell& cell,
                                        const expression::Biases& biases) {
  command::GuidanceParameters guidance{.linear_max = parameters.velocity, .angular_max = parameters.turn};
  if (parameters.enabled) guidance.enabled = expression::state_of(*parameters.enabled, cell, biases);
  for (const std::string& channel : {cell.override_channel, command::speed_channel(parameters.arm)}) {
    if (!cell.channels.contains(channel)) continue;
    const State going = not_paused(cell, channel);
    guidance.enabled = guidance.enabled ? *guidance.enabled && going : going;
  }
  return guidance;
}

command::RuntimeCommand freedrive_command(const FreedriveParameters& parameters, const expression::Cell& cell,
                                          const expression::Biases& biases) {
  const auto guidance = guidance_of(parameters, cell, biases);
  command::RuntimeCommand guided("freedrive", command::arm(cell, parameters.arm),
                                 command::freedrive(cell, parameters.arm, guidance, biases));
  if (parameters.until) guided.on_entered(expression::state_of(*parameters.until, cell, biases), cancel(guided));
  if (parameters.seconds) guided.on_entered(guided.started().held_for(*parameters.seconds), cancel(guided));
  if (parameters.abort_if)
    activity::add_abort(guided, expression::state_of(*parameters.abort_if, cell, biases), guided.name());
  return guided;
}

/// From the control mode that the arm is in back into that. Where it is then is unknown before the run.
class FreedriveActivity final : public activity::ActivityModel {
 public:
  FreedriveActivity(FreedriveParameters parameters, const expression::Cell& cell, expression::Biases biases)
      : activity::ActivityModel(parameters.arm + " freedrive"),
        parameters_(std::move(parameters)),
        biases_(std::move(biases)) {
    if (command::freedrive_kind(cell, parameters_.arm) == command::FreedriveKind::kSprings)
      modes_[parameters_.arm] = device::ControlMode::kJointImpedance;
  }

  [[nodiscard]] std::vector<std::string> actuators() const override { return {parameters_.arm}; }
  [[nodiscard]] bool begins_alone() const override { return !modes_.empty(); }

  [[nodiscard]] Result<activity::PlannedActivity> prepare(const activity::PlanningContext& planning) const override {
    activity::PlannedActivity planned;
    const auto guided = freedrive_command(parameters_, planning.cell, biases_);
    planned.command = guided;
    planned.modes = modes_;
    planned.returns = !modes_.empty();
    planned.touching = {parameters_.arm};
    planned.end_states[parameters_.arm] = {};
    planned.verdict = [key = guided.name()](const activity::RunView& run) {
      return activity::abort_diagnostics(run, key);
    };
    const activity::ActuatorState& before = planning.predecessors.find(parameters_.arm)->second.at_end;
    // Where a change of the mode takes the set point to shows only then.
    if (modes_.empty() && before.q) planned.begins[parameters_.arm].push_back(activity::seam_at_rest(*before.q));
    return planned;
  }

 private:
  FreedriveParameters parameters_;
  expression::Biases biases_;
  activity::ControlModes modes_;  ///< into which the arm is brought before; empty: none
};

class FreedriveRun final : public ScheduledRun {
 public:
  explicit FreedriveRun(const FreedriveParameters& parameters) : parameters_(parameters) {}

 private:
  [[nodiscard]] activity::ActivityPtr activity(activity::Context& context) override {
    return freedrive_activity(parameters_, context.cell, context.variables.biases);
  }
  /// The control mode, and what the activity is made of, are not among the keys of this step.
  [[nodiscard]] std::string location_of(std::string pointer) const override {
    return pointer == "/abort_if" ? pointer : std::string();
  }

  const FreedriveParameters& parameters_;
};

class FreedriveStep final : public Step {
 public:
  explicit FreedriveStep(FreedriveParameters parameters) : parameters_(std::move(parameters)) {}

  /// Where a hand leads the arm shows only in the run: the rehearsal goes on from where it is.
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    rehearsal.touched[parameters_.arm] = false;
    rehearsal.duration += parameters_.seconds.value_or(0.0);
    if (rehearsal.cell.arms.at(parameters_.arm).device == nullptr) return;  // only names are known
    const auto mapped = command::map(freedrive_command(parameters_, rehearsal.cell, {}));
    if (!mapped) {
      for (const Diagnostic& one : mapped.error().list()) diagnostics.error(one.code, pointer, one.message, one.hint);
      return;
    }
    rehearse_net(mapped->net, rehearsal, pointer, diagnostics);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<FreedriveRun>(parameters_); }
  [[nodiscard]] ArmTools arm_tools() const override {
    return {{parameters_.arm, parameters_.tool, parameters_.pointer}};
  }

 private:
  FreedriveParameters parameters_;
};

/// In a program of a file nothing else ends it.
std::unique_ptr<Step> read_freedrive_step(const OperationSource& source) {
  FreedriveParameters parameters = read_parameters<freedrive_parameters>(source);
  if (!source.json.contains("until") && !source.json.contains("seconds")) {
    source.diagnostics.error(Code::kMissing, source.pointer, "no end condition is given", "Give 'until' or 'seconds'");
  }
  return std::make_unique<FreedriveStep>(std::move(parameters));
}

}  // namespace

const ParameterTable<FreedriveParameters>& freedrive_parameters() {
  static const auto table = [] {
    ParameterTable<FreedriveParameters> freedrive;
    freedrive.name("arm", NameOf::kArm, &FreedriveParameters::arm, "Arm that a person guides.")
        .condition("enabled", &FreedriveParameters::enabled, "Dead-man switch: the arm yields only while this is true.")
        .condition("until", &FreedriveParameters::until, "Ends when this becomes true.")
        .number("seconds", "s", &FreedriveParameters::seconds, {.low = 0.0, .high = 3600.0}, "Ends after this time.")
        .number("velocity_m_s", "m/s", &FreedriveParameters::velocity, {.low = 0.0, .high = 1.0, .low_open = true},
                "Largest speed of the tool.")
        .number("turn_deg_s", "deg/s", &FreedriveParameters::turn, {.low = 0.0, .high = 180.0, .low_open = true},
                "Largest angular speed of the tool.")
        .condition("abort_if", &FreedriveParameters::abort_if, "Comes to rest and fails when this becomes true.")
        .tool(&FreedriveParameters::tool);
    return freedrive;
  }();
  return table;
}

activity::ActivityPtr freedrive_activity(const FreedriveParameters& parameters, const expression::Cell& cell,
                                         const expression::Biases& biases) {
  return std::make_shared<const FreedriveActivity>(parameters, cell, biases);
}

Operation freedrive_operation() {
  return {.name = "freedrive",
          .doc = "A person guides an arm by hand.",
          .parameters = rows_of<freedrive_parameters>,
          .read_step = read_freedrive_step};
}

}  // namespace takt::operations
