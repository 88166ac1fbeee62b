#include "core/operations/freedrive.h"

#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/activity/freedrive_activity.h"
#include "core/expression/condition_state.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"

namespace takt::activity {
namespace {

/// What the parameters say, with the sensors of a cell.
struct Guiding {
  Guiding(const FreedriveParameters& parameters, const command::Cell& cell, const command::Biases& biases)
      : wish{.linear_max = parameters.velocity, .angular_max = parameters.turn},
        end{.until = {}, .seconds = parameters.seconds} {
    if (parameters.enabled) wish.enabled = command::state_of(*parameters.enabled, cell, biases);
    if (parameters.until) end.until = command::state_of(*parameters.until, cell, biases);
  }
  command::GuidanceParameters wish;
  FreedriveEnd end;
};

class FreedriveRun final : public ScheduledRun {
 public:
  explicit FreedriveRun(const FreedriveParameters& parameters) : parameters_(parameters) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context& context) override {
    return freedrive_activity(parameters_, context.cell, context.variables.biases);
  }
  /// The control mode, and what the activity is made of, are not among the keys of this step.
  [[nodiscard]] std::string location_of(std::string) const override { return {}; }

  const FreedriveParameters& parameters_;
};

class FreedriveStep final : public Step {
 public:
  explicit FreedriveStep(FreedriveParameters parameters) : parameters_(std::move(parameters)) {}

  /// Where a hand leads the arm shows only in the run: it is taken to stay.
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    rehearsal.touched[parameters_.arm] = false;
    rehearsal.duration += parameters_.seconds.value_or(0.0);
    if (rehearsal.cell.arms.at(parameters_.arm).device == nullptr) return;  // only names are known
    const Guiding guiding(parameters_, rehearsal.cell, {});
    const auto mapped = command::map(freedrive_command(rehearsal.cell, parameters_.arm, guiding.wish, guiding.end, {}));
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

/// In a program nobody else ends it.
std::unique_ptr<Step> read_freedrive_step(const OperationSource& source) {
  FreedriveParameters parameters = read_parameters<freedrive_parameters>(source);
  if (!source.json.contains("until") && !source.json.contains("seconds")) {
    source.diagnostics.error(Code::kMissing, source.pointer, "no end condition is given", "'until' or 'seconds'");
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
        .tool(&FreedriveParameters::tool);
    return freedrive;
  }();
  return table;
}

ActivityPtr freedrive_activity(const FreedriveParameters& parameters, const command::Cell& cell,
                               const command::Biases& biases) {
  const Guiding guiding(parameters, cell, biases);
  return freedrive_activity(cell, parameters.arm, guiding.wish, guiding.end, biases);
}

Operation freedrive_operation() {
  return {.name = "freedrive",
          .doc = "A person guides an arm by hand.",
          .parameters = rows_of<freedrive_parameters>,
          .read_step = read_freedrive_step};
}

}  // namespace takt::activity
