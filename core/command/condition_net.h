#pragma once

#include <string>
#include <string_view>

#include "core/command/cell.h"
#include "core/command/condition.h"
#include "core/net/description.h"

/// Parts that the nets of commands are put together from. Realtime: setup.
namespace takt::command {

/// The beginning of the ids of a device's primitives. Devices may have any name, ids have no '.', '/', blanks and
/// control characters: these, and the escape itself, stand as % and two hexadecimal digits, so that no two names share
/// an id.
[[nodiscard]] std::string id_of(std::string_view kind, std::string_view device);

/// A two-input gate over two ports. @return the port of the result.
std::string add_gate(net::NetDescription& net, const std::string& id, const char* type, const std::string& a,
                     const std::string& b);

/// The net ends when the port is true.
void add_end(net::NetDescription& net, const std::string& condition);

/// Measured positions of an arm, one primitive however many ask. @return the port of q.
std::string add_arm_state(net::NetDescription& net, const std::string& arm);

/// A sensor's reading without the weight of what hangs on it. @return the port of the wrench.
std::string add_compensated_wrench(net::NetDescription& net, const std::string& name, const Cell& cell);

/// Everything that a condition reads, and the condition. @return the port of its value.
/// @param id      beginning of the ids of the primitives that are made for its parts
/// @param biases  of the sensors in it; a sensor that was never tared has none
std::string add_condition(net::NetDescription& net, const Condition& condition, const std::string& id, const Cell& cell,
                          const Biases& biases);

}  // namespace takt::command
