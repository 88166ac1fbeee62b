#include "core/operations/press.h"

namespace takt::activity {
namespace {

Pressing to_pressing(const PressParameters& parameters) {
  Pressing pressing = pressing_of(parameters, "press");
  pressing.seconds = parameters.seconds;
  return pressing;
}

/// Nobody else ends a step.
Pressing to_step(PressParameters parameters) {
  constexpr double kHold_s = 0.5;
  if (!parameters.seconds && !parameters.until) parameters.seconds = kHold_s;
  return to_pressing(parameters);
}

std::unique_ptr<Step> read_press_step(const OperationSource& source) {
  return pressing_step(to_step(read_parameters<press_parameters>(source)));
}

std::unique_ptr<OperationCommand> read_press_command(const OperationSource& source) {
  return pressing_command(to_pressing(read_parameters<press_parameters>(source)));
}

}  // namespace

std::unique_ptr<OperationCommand> press_command(const PressParameters& parameters) {
  return pressing_command(to_step(parameters));
}

const ParameterTable<PressParameters>& press_parameters() {
  static const auto table = pressing_parameters<PressParameters>().number(
      "seconds", "s", &PressParameters::seconds, {.low = 0.0, .high = 3600.0},
      "How long the force is held once it is reached; without 'until' 0.5 as a step, without end in a transaction.");
  return table;
}

Operation press_operation() {
  return {.name = "press",
          .doc = "Approaches along a direction until contact, then presses with a force.",
          .parameters = rows_of<press_parameters>,
          .read_step = read_press_step,
          .read_command = read_press_command};
}

}  // namespace takt::activity
