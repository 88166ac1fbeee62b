#include "core/command/actions/device_commands.h"

#include "core/expression/condition_state.h"

namespace takt::command {

WaitCommand wait_command(const StateSource& condition, std::optional<double> timeout, const Cell& cell,
                         const Biases& biases) {
  const State until = state_of(condition, cell, biases);
  WaitCommand command("wait", until, timeout);
  command.observe(observed::kCondition, BooleanSensor(until.node()));
  return command;
}

}  // namespace takt::command
