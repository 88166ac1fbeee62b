#pragma once

#include <optional>
#include <string>
#include <variant>

#include "core/command/command.h"
#include "core/expression/cell.h"
#include "core/expression/condition_state.h"

/// Commands that move no arm, with what they show of their end. Realtime: setup.
namespace takt::command {

/// What a gripper is to do until its fingers stand still.
struct GripCommand {
  std::string gripper;
  double width = 0.0;  ///< m
  double speed = 0.0;  ///< m/s, of the width
  double force = 0.0;  ///< N
};

/// Names of observations.
namespace observed {
inline constexpr const char* kHolding = "holding";      ///< Boolean, of grip_command()
inline constexpr const char* kWidth = "width";          ///< Real, m, of grip_command()
inline constexpr const char* kCondition = "condition";  ///< Boolean, of wait_command(); null: a sensor did not answer
inline constexpr const char* kBias = "bias";            ///< Wrench in the measuring frame, of tare_command()
}  // namespace observed

/// Ends when the fingers stand still, or when it is cancelled: then the stop reaction keeps the grip.
[[nodiscard]] RuntimeCommand grip_command(const GripCommand& command, const Cell& cell);

/// A digital or an analog value.
using SignalValue = std::variant<bool, double>;

/// Brings an output of the cell to a value, an analog one as fast as it may; the value stays when the net has ended.
[[nodiscard]] RuntimeCommand set_command(const std::string& output, const SignalValue& value, const Cell& cell);

/// Waits until a condition holds, or `timeout` s have passed, or it is cancelled.
[[nodiscard]] WaitCommand wait_command(const StateSource& condition, std::optional<double> timeout, const Cell& cell,
                                       const Biases& biases);

}  // namespace takt::command
