#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/diagnostics.h"

namespace takt::hw {

/// One end of a wire: an IPv4 address and a port.
struct Endpoint {
  std::uint32_t host = 0;  ///< 127.0.0.1 is 0x7F00'0001; 0: any address of this machine
  std::uint16_t port = 0;  ///< 0: any free one, chosen when it is opened

  [[nodiscard]] bool is_loopback() const { return (host >> 24) == 127; }
  auto operator<=>(const Endpoint&) const = default;
};

inline constexpr std::uint32_t kLoopback = 0x7F00'0001;

/// "192.0.2.1:49938". Realtime: setup.
[[nodiscard]] std::string to_string(const Endpoint& endpoint);

/// Reads "HOST", "HOST:PORT" or ":PORT"; HOST is a dotted IPv4 address or "localhost", none is `host_default`. Names
/// are not looked up: that waits, and a robot's address is fixed. @return it, or an error that says what is expected.
/// Realtime: setup.
[[nodiscard]] Result<Endpoint> parse_endpoint(std::string_view text, std::uint16_t port_default,
                                              std::uint32_t host_default = kLoopback);

}  // namespace takt::hw
