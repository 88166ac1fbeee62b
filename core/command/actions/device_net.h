#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "core/expression/cell.h"
#include "core/expression/condition.h"
#include "core/net/description.h"

/// Nets of single commands that move no arm, through the one mapping (mapping.h); or all that is wrong with them.
/// Realtime: setup.
namespace takt::command {

/// Tells a gripper what to do and waits until its fingers stand.
struct GripCommand {
  std::string gripper;
  double width = 0.0;  ///< m
  double speed = 0.0;  ///< m/s, of the width
  double force = 0.0;  ///< N
};

/// The net ends when the fingers stand, or when it is cancelled: then the stop reaction keeps the grip.
[[nodiscard]] Result<net::NetDescription> grip_net(const GripCommand& command, const Cell& cell);
namespace grip_ports {
inline constexpr std::string_view kHolding = "grip/state.holding";  ///< Boolean
inline constexpr std::string_view kWidth = "grip/state.width";      ///< Real, m
}  // namespace grip_ports

/// A digital or an analog value.
using SignalValue = std::variant<bool, double>;

/// Brings an output of the cell to a value, an analog one as fast as it may; the value stays when the net has ended.
/// @param period  of the core, s
[[nodiscard]] Result<net::NetDescription> set_net(const std::string& output, const SignalValue& value, const Cell& cell,
                                                  double period);

/// A net that waits, and where the answer stands when it has ended.
struct WaitNet {
  net::NetDescription net;
  std::string condition_port;  ///< Boolean: true = it holds; null = a sensor did not answer
};

/// Waits until a condition holds, or `timeout` s have passed, or the net is cancelled.
[[nodiscard]] Result<WaitNet> wait_net(const Condition& condition, std::optional<double> timeout, const Cell& cell,
                                       const Biases& biases);

}  // namespace takt::command
