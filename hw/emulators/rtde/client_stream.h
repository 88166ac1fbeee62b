#pragma once

#include <string>

#include "hw/emulators/rtde/controller.h"

/// What a controller sends on its ports 30001 to 30003, in its own byte layout (big-endian, packed).
namespace takt::hw::rtde {

/// Package of type 16 of the primary and secondary interface: all that is told of the robot ten times a second.
[[nodiscard]] std::string make_robot_state(Controller& controller);
/// The first message on every connection to the primary and secondary interface.
[[nodiscard]] std::string make_version_message(Controller& controller);
/// Package of type 20 of the primary interface.
[[nodiscard]] std::string make_message(const ControllerEvent& event);
/// The package of the realtime interface: 1116 bytes, from 5.10 on 1220.
[[nodiscard]] std::string make_realtime_state(Controller& controller);

}  // namespace takt::hw::rtde
