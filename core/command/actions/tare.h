#pragma once

#include <cstdint>
#include <string>

#include "core/command/command.h"
#include "core/expression/cell.h"

namespace takt::command {

/// Averages a sensor's reading, tool weight removed, over `cycles` cycles while the arms are at rest. Observes
/// observed::kBias, a wrench in the measuring frame; null if the sensor was silent for half a second, or the command
/// was cancelled.
[[nodiscard]] WaitCommand tare_command(const std::string& sensor, std::int64_t cycles, const expression::Cell& cell);

}  // namespace takt::command
