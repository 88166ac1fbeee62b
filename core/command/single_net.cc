#include "core/command/single_net.h"

#include <cstdlib>

#include <fmt/core.h>

namespace takt::command {

MappedCommand single_net(const Command& command, const std::string& title, Nanoseconds period) {
  auto mapped = map(command, period);
  if (!mapped) {
    fmt::print(stderr, "a command that must be right is not: {}\n", mapped.error().to_string());
    std::abort();
  }
  mapped->net.name = title;
  return std::move(*mapped);
}

}  // namespace takt::command
