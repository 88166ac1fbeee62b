#include "core/command/actions/device_net.h"

#include <cmath>

#include "core/command/actions/device_action.h"
#include "core/command/single_net.h"
#include "core/expression/condition_state.h"

namespace takt::command {

Result<net::NetDescription> grip_net(const GripCommand& command, const Cell& cell) {
  const GripWish wish{.width = command.width, .speed = command.speed, .force = command.force};
  return net_of(
      single_net(RuntimeCommand("grip", gripper(cell, command.gripper), grip(wish)), "grip " + command.gripper));
}

Result<net::NetDescription> set_net(const std::string& output, const SignalValue& value, const Cell& cell,
                                    double period) {
  const bool* level = std::get_if<bool>(&value);
  const RuntimeCommand command("set", takt::command::output(cell, output),
                               level != nullptr ? set_value(*level) : set_value(std::get<double>(value)));
  return net_of(single_net(command, "set " + output, static_cast<Nanoseconds>(std::llround(1e9 * period))));
}

Result<WaitNet> wait_net(const Condition& condition, std::optional<double> timeout, const Cell& cell,
                         const Biases& biases) {
  const State until = state_of(condition, cell, biases);
  WaitCommand command("wait", until, timeout);
  command.observe("condition", BooleanSensor(until.node()));
  auto mapped = single_net(command, "wait");
  if (!mapped) return std::unexpected(std::move(mapped.error()));
  return WaitNet{.net = std::move(mapped->net), .condition_port = mapped->observed.at("condition")};
}

}  // namespace takt::command
