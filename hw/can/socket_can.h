#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "core/base/diagnostics.h"
#include "hw/can/can_link.h"

namespace takt::hw {

/// Could be the name of a network interface, such as "can0": letters, digits, '-' and '_', at most 15.
[[nodiscard]] bool is_interface_name(std::string_view text);

/// Opens a CAN interface of the machine (SocketCAN). Its bit rate is set by whoever set the interface up. Errors name
/// the interface and what to do. Realtime: setup.
[[nodiscard]] Result<std::unique_ptr<CanLink>> open_socket_can(const std::string& interface);

}  // namespace takt::hw
