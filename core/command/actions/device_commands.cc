#include "core/command/actions/device_commands.h"

#include "core/command/actions/device_action.h"
#include "core/expression/condition_state.h"

namespace takt::command {

RuntimeCommand grip_command(const GripCommand& command, const Cell& cell) {
  const FingerParameters wish{.width = command.width, .speed = command.speed, .force = command.force};
  RuntimeCommand gripped("grip", gripper(cell, command.gripper), grip(wish));
  gripped.observe(observed::kHolding, BooleanSensor(gripped.action().state("holding").node()));
  gripped.observe(observed::kWidth, gripped.action().value("width"));
  return gripped;
}

RuntimeCommand set_command(const std::string& output, const SignalValue& value, const Cell& cell) {
  const bool* level = std::get_if<bool>(&value);
  return {"set", takt::command::output(cell, output),
          level != nullptr ? set_value(*level) : set_value(std::get<double>(value))};
}

WaitCommand wait_command(const StateSource& condition, std::optional<double> timeout, const Cell& cell,
                         const Biases& biases) {
  const State until = state_of(condition, cell, biases);
  WaitCommand command("wait", until, timeout);
  command.observe(observed::kCondition, BooleanSensor(until.node()));
  return command;
}

}  // namespace takt::command
