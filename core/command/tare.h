#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/command/command.h"
#include "core/expression/cell.h"
#include "core/net/description.h"

namespace takt::command {

/// Averages a sensor's reading, tool weight taken out, over `cycles` cycles while the arms stand still. Observes
/// "bias", a wrench in the measuring frame; null if the sensor was silent for half a second, or the command was
/// cancelled.
[[nodiscard]] WaitCommand tare_command(const std::string& sensor, std::int64_t cycles, const Cell& cell);

/// The net of tare_command(), or what is wrong with it. Its result is on kBias. Realtime: setup.
[[nodiscard]] Result<net::NetDescription> tare_net(const std::string& sensor, std::int64_t cycles, const Cell& cell);
namespace tare_ports {
inline constexpr std::string_view kBias = "tare.bias";  ///< Wrench in the measuring frame
}

}  // namespace takt::command
