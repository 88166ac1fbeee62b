#include "core/command/actions/device_commands.h"

#include "core/expression/condition_state.h"

namespace takt::command {

WaitCommand wait_command(const expression::StateSource& condition, std::optional<double> timeout,
                         const expression::Cell& cell, const expression::Biases& biases) {
  const expression::State until = expression::state_of(condition, cell, biases);
  WaitCommand command("wait", until, timeout);
  command.observe(observed::kCondition, expression::BooleanSensor(until.node()));
  return command;
}

}  // namespace takt::command
