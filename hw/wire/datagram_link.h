#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/time.h"
#include "hw/wire/endpoint.h"

namespace takt::hw {

/// What a link could not send or receive; counters only grow.
struct DatagramCounts {
  std::uint64_t sent = 0, received = 0;
  std::uint64_t unsent = 0;  ///< the system had no room, or refused; the datagram is lost
  std::uint64_t errors = 0;  ///< receive errors, such as "connection refused" of a peer that is not there yet
};

/// Sends and receives datagrams at one local endpoint. Nothing here waits but wait(); no exception, no signal. A link
/// is used by one thread and closed by its destructor.
class DatagramLink {
 public:
  /// Largest datagram of any protocol here, bytes: one Ethernet frame.
  static constexpr std::size_t kLargest = 1472;

  struct Received {
    std::size_t size = 0;  ///< of the datagram as it was sent: larger than the buffer if it was cut off
    Endpoint from;
  };

  virtual ~DatagramLink() = default;
  /// @return false: lost here, and counted. Realtime: cyclic.
  virtual bool send(std::span<const std::byte> datagram, const Endpoint& to) = 0;
  /// Takes the datagram that came next, if any is there. Realtime: cyclic.
  virtual std::optional<Received> receive(std::span<std::byte> buffer) = 0;
  /// Waits until receive() would give a datagram, at most `timeout` ns, and until a signal at most. Virtual time does
  /// not go on meanwhile. @return false if none is there.
  virtual bool wait(Nanoseconds timeout) = 0;
  /// With the port that was chosen.
  [[nodiscard]] virtual Endpoint local() const = 0;
  [[nodiscard]] virtual DatagramCounts counts() const = 0;
};

}  // namespace takt::hw
