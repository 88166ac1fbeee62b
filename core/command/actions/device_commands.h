#pragma once

#include <optional>
#include <string>
#include <variant>

#include "core/command/command.h"
#include "core/expression/cell.h"
#include "core/expression/condition_state.h"

/// Commands that move no arm, with what they show of their end. Realtime: setup.
namespace takt::command {

/// Names of observations.
namespace observed {
inline constexpr const char* kCondition = "condition";  ///< Boolean, of wait_command(); null: a sensor did not answer
inline constexpr const char* kBias = "bias";            ///< Wrench in the measuring frame, of tare_command()
}  // namespace observed

/// A digital or an analog value.
using SignalValue = std::variant<bool, double>;

/// Waits until a condition holds, or `timeout` s have passed, or it is cancelled.
[[nodiscard]] WaitCommand wait_command(const expression::StateSource& condition, std::optional<double> timeout,
                                       const expression::Cell& cell, const expression::Biases& biases);

}  // namespace takt::command
