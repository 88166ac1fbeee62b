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
  std::string place, message, way_out;
};

inline RuntimeCommand move(const World& world, const Action& action) { return {"move", world.arm_actuator(), action}; }

/// Of what is laid over motions.
[[nodiscard]] std::vector<BrokenCommand> broken_overlays();

}  // namespace takt::command
