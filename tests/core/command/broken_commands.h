#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/core/command/command_cell.h"

namespace takt::command {

using World = test::CommandCell;

/// A command that breaks one rule.
struct BrokenCommand {
  std::string rule;  ///< of docs/command-layer.md; empty: one without a number
  std::function<Command(World& world)> make;
  std::string place;  ///< JSON pointer of the diagnostic
  Code code;
  std::vector<std::string> names = {};  ///< in its message or hint
};

inline RuntimeCommand move(const World& world, const Action& action) { return {"move", world.arm_actuator(), action}; }

/// The smallest commands, by name.
inline RuntimeCommand driver(const World& world, const std::string& name) {
  return {name, world.driver(), set_value(true)};
}
inline RuntimeCommand lamp(const World& world, const std::string& name) {
  return {name, world.lamp(), set_value(true)};
}
inline WaitCommand wait_for(const expression::State& until) { return {"wait", until}; }
inline WaitCommand see(const World& world, const expression::RealSensor& sensor) {
  (void)world;
  return wait_for(expression::is_greater(sensor, 1.0));
}

/// "all": the first starts with it, the second does not.
inline TransactionCommand all_of(const Command& first, const Command& second) {
  TransactionCommand all("all");
  all.add_started(first).add(second);
  return all;
}

/// Of event handlers, of what ends a transaction, and of the tree of commands.
[[nodiscard]] std::vector<BrokenCommand> broken_handlers();
/// Of what is laid over motions.
[[nodiscard]] std::vector<BrokenCommand> broken_overlays();

}  // namespace takt::command
