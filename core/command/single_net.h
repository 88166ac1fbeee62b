#pragma once

#include <string>

#include "core/command/mapping.h"

namespace takt::command {

/// The net of a command whose parts are known to be right; what is wrong all the same is a programming error (abort).
/// @param title  of the net. Realtime: setup.
[[nodiscard]] MappedCommand single_net(const Command& command, const std::string& title,
                                       Nanoseconds period = kMillisecond);

}  // namespace takt::command
