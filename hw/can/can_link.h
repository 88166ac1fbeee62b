#pragma once

#include <cstdint>
#include <optional>

#include "core/base/time.h"
#include "hw/can/frame.h"

namespace takt::hw {

/// Frames that a link did not send or hand on; counters only grow.
struct CanCounts {
  std::uint64_t sent = 0, received = 0;
  std::uint64_t unsent = 0;     ///< no room in the queue, or the interface is down: the frame is lost
  std::uint64_t misread = 0;    ///< no data frames with an identifier of 11 bits, or damaged
  std::uint64_t strangers = 0;  ///< frames in datagrams of somebody else
};

/// A node's access to a CAN bus. It does not see its own frames. Nothing here waits but wait(); no exception. One
/// thread; the destructor closes it.
class CanLink {
 public:
  virtual ~CanLink() = default;
  /// @return false: lost here, and counted. Realtime: cyclic.
  virtual bool send(const CanFrame& frame) = 0;
  /// Takes the frame that came next, if any is there. Realtime: cyclic.
  virtual std::optional<CanFrame> receive() = 0;
  /// Waits until receive() might give one, at most `timeout` ns. Virtual time does not go on meanwhile.
  virtual bool wait(Nanoseconds timeout) = 0;
  [[nodiscard]] virtual CanCounts counts() const = 0;
};

}  // namespace takt::hw
