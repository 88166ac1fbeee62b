#pragma once

#include "core/command/cell.h"
#include "core/command/condition.h"
#include "core/command/state.h"

namespace takt::command {

/// A condition of a file as a state; a sensor that was never tared has no bias. Realtime: setup.
[[nodiscard]] State state_of(const Condition& condition, const Cell& cell, const Biases& biases);

/// The number that a comparison with a force/torque sensor looks at, N or Nm. Realtime: setup.
[[nodiscard]] RealSensor quantity_of(const std::string& sensor, Quantity quantity, const Cell& cell,
                                     const Biases& biases);

}  // namespace takt::command
