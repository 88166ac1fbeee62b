#include "hw/wire/endpoint.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>

namespace takt::hw {
namespace {

template <class Number>
std::optional<Number> whole(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return number;
}

std::optional<std::uint32_t> parse_host(std::string_view text) {
  if (text == "localhost") return kLoopback;
  std::uint32_t host = 0;
  for (int part = 0; part < 4; ++part) {
    const std::size_t dot = part < 3 ? text.find('.') : text.size();
    if (dot == text.npos) return std::nullopt;
    const auto byte = whole<std::uint8_t>(text.substr(0, dot));
    if (!byte) return std::nullopt;
    host = host << 8 | *byte;
    text.remove_prefix(std::min(dot + 1, text.size()));
  }
  return host;
}

}  // namespace

std::string to_string(const Endpoint& endpoint) {
  const std::uint32_t h = endpoint.host;
  return fmt::format("{}.{}.{}.{}:{}", h >> 24, h >> 16 & 0xff, h >> 8 & 0xff, h & 0xff, endpoint.port);
}

Result<Endpoint> parse_endpoint(std::string_view text, std::uint16_t port_default, std::uint32_t host_default) {
  constexpr const char* kExpected = "HOST, HOST:PORT or :PORT, e.g. 192.0.2.1:49938";
  const std::size_t colon = text.find(':');
  const std::string_view host_text = text.substr(0, colon);
  const auto host = host_text.empty() ? std::optional(host_default) : parse_host(host_text);
  if (!host) return failure(Code::kInvalidValue, "", fmt::format("'{}' is not an IPv4 address", host_text), kExpected);
  if (colon == text.npos) return Endpoint{*host, port_default};
  const auto port = whole<std::uint16_t>(text.substr(colon + 1));
  if (!port)
    return failure(Code::kInvalidValue, "", fmt::format("'{}' is not a port", text.substr(colon + 1)), kExpected);
  return Endpoint{*host, *port};
}

}  // namespace takt::hw
