#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/base/time.h"
#include "hw/wire/endpoint.h"

namespace takt::hw {

/// One connection of a byte stream (TCP). Nothing here waits but wait(); no exception, no signal (a broken pipe is a
/// state). The stream keeps no message boundaries: what was sent may arrive in any pieces. A link is used by one
/// thread; its destructor closes it.
class StreamLink {
 public:
  enum class State : std::uint8_t {
    kConnecting,  ///< nothing can be sent yet
    kOpen,
    kEnded,  ///< the other side sends no more, and all that it sent has been received
    kFailed  ///< refused, reset, or closed here: error() says why
  };

  virtual ~StreamLink() = default;
  /// As of now; a connection that is being made is looked after by this call. Realtime: cyclic.
  [[nodiscard]] virtual State state() = 0;
  /// @return how many of the first bytes were accepted: fewer than given, or 0, if the peer does not read or the link
  /// is not open. The caller keeps the rest. Realtime: cyclic.
  virtual std::size_t send(std::span<const std::byte> bytes) = 0;
  /// Takes what has come. @return how many bytes; 0 says nothing of the state. Realtime: cyclic.
  virtual std::size_t receive(std::span<std::byte> buffer) = 0;
  /// Waits until there is something to receive, or the state changes, at most `timeout` ns. Virtual time does not go on
  /// meanwhile. @return false if nothing happened.
  virtual bool wait(Nanoseconds timeout) = 0;
  /// Ends the connection; the state is kFailed from here on.
  virtual void close() = 0;
  [[nodiscard]] virtual Endpoint local() const = 0;
  [[nodiscard]] virtual Endpoint remote() const = 0;
  /// Why the link failed; empty while it has not. Realtime: setup.
  [[nodiscard]] virtual std::string error() const = 0;
};

/// Accepts connections at one local endpoint until it is destroyed. One thread.
class StreamListener {
 public:
  virtual ~StreamListener() = default;
  /// @return the connection that came next, open; null if none waits. Realtime: setup.
  virtual std::unique_ptr<StreamLink> accept() = 0;
  /// Waits until accept() would give one, at most `timeout` ns. @return false if none is there.
  virtual bool wait(Nanoseconds timeout) = 0;
  /// With the port that was chosen.
  [[nodiscard]] virtual Endpoint local() const = 0;
};

}  // namespace takt::hw
