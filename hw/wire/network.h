#pragma once

#include <memory>

#include "hw/wire/datagram_link.h"
#include "hw/wire/stream_link.h"

namespace takt::hw {

/// Opens links: on the machine's sockets (PosixNetwork) or on a wire in the process (VirtualNetwork). It outlives what
/// it opened. Errors name the endpoint and the cause ("address already in use"). Realtime: setup.
class Network {
 public:
  virtual ~Network() = default;
  [[nodiscard]] virtual Result<std::unique_ptr<DatagramLink>> open_datagrams(const Endpoint& local) = 0;
  [[nodiscard]] virtual Result<std::unique_ptr<StreamListener>> listen(const Endpoint& local) = 0;
  /// Begins to connect and returns at once; StreamLink::state() tells how it goes on.
  [[nodiscard]] virtual Result<std::unique_ptr<StreamLink>> connect(const Endpoint& remote) = 0;
};

}  // namespace takt::hw
