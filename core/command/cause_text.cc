#include "core/command/cause_text.h"

#include <fmt/format.h>

namespace takt::command {

std::string cause_text(const net::Cause& cause, const Cell& cell) {
  const std::string_view text = cause.text.view();
  if (cause.code != net::Cause::Code::kDevice) return std::string(text);
  for (const auto& [name, arm] : cell.arms) {
    // In the cycle there is room for a number only.
    const device::Arm& device = *arm.device;
    const bool is_its = text.starts_with(device.name() + ": not ready, fault ");
    const std::string words = is_its && device.has_sample() && device.sample().fault != 0 ? device.fault_text() : "";
    if (!words.empty()) return fmt::format("{}: {}", device.name(), words);
  }
  return std::string(text);
}

}  // namespace takt::command
