#pragma once

#include <string>

#include "core/command/mapping.h"

namespace takt::command {

/// The net of a command that was made from one request, a step or a call.
/// @param title  of the net. @return the net, or all that check() finds. Realtime: setup.
[[nodiscard]] Result<MappedCommand> single_net(const Command& command, const std::string& title,
                                               Nanoseconds period = kMillisecond);

/// The net alone.
[[nodiscard]] inline Result<net::NetDescription> net_of(Result<MappedCommand> mapped) {
  if (!mapped) return std::unexpected(std::move(mapped.error()));
  return std::move(mapped->net);
}

}  // namespace takt::command
