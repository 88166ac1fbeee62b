#include "core/command/cause_text.h"

#include <charconv>

#include <fmt/format.h>

namespace takt::command {
namespace {

/// Where `mark` begins in `text`: at its beginning or behind another cause, so that 'left_arm' does not count as 'arm'.
std::size_t find_part(std::string_view text, std::string_view mark) {
  constexpr std::string_view kBehind = "; ";
  std::size_t at = text.find(mark);
  while (at != std::string_view::npos && at != 0 && !text.substr(0, at).ends_with(kBehind))
    at = text.find(mark, at + 1);
  return at;
}

/// The number that `text` begins with; 0 where it is none, or may have been cut with the text.
std::uint32_t leading_number(std::string_view text, bool may_be_cut, std::size_t& digits) {
  std::uint32_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  digits = static_cast<std::size_t>(read.ptr - text.data());
  return read.ec == std::errc{} && !(may_be_cut && digits == text.size()) ? number : 0;
}

}  // namespace

std::string cause_text(const net::Cause& cause, const expression::Cell& cell) {
  const std::string_view text = cause.text.view();
  if (cause.code != net::Cause::Code::kDevice) return std::string(text);
  // In the cycle there is room for a number only. It is looked up as it was then: the device may be well again.
  for (const auto& [name, arm] : cell.arms) {
    const device::Arm& device = *arm.device;
    const std::string mark = device.name() + ": not ready, fault ";
    const std::size_t at = find_part(text, mark);
    if (at == std::string_view::npos) continue;
    std::size_t digits = 0;
    const bool may_be_cut = text.size() == cause.text.bytes.size();
    const std::uint32_t fault = leading_number(text.substr(at + mark.size()), may_be_cut, digits);
    const std::string words = fault != 0 ? device.fault_text(fault) : "";
    if (words.empty()) continue;
    return fmt::format("{}{}: {}{}", text.substr(0, at), device.name(), words, text.substr(at + mark.size() + digits));
  }
  return std::string(text);
}

}  // namespace takt::command
