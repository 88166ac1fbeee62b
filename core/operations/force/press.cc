#include "core/operations/force/press.h"

#include <utility>

#include "core/operations/command/command_step.h"

namespace takt::operations {

std::unique_ptr<OperationCommand> press_command(const PressParameters& parameters) {
  constexpr double kHold_s = 0.5;
  Pressing pressing = pressing_of(parameters, "press");
  pressing.seconds = parameters.seconds;
  if (!parameters.until) pressing.seconds_alone = kHold_s;
  return pressing_command(std::move(pressing));
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
          .read_step = step_of_command,
          .read_command = make_command<press_parameters, press_command>};
}

}  // namespace takt::operations
