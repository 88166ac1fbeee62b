#include "core/command/single_net.h"

namespace takt::command {

Result<MappedCommand> single_net(const Command& command, const std::string& title, Nanoseconds period) {
  auto mapped = map(command, period);
  if (mapped) mapped->net.name = title;
  return mapped;
}

}  // namespace takt::command
