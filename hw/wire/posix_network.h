#pragma once

#include "hw/wire/network.h"

namespace takt::hw {

/// UDP and TCP over IPv4 sockets of the machine: non-blocking, closed on exec, TCP without Nagle's delay. A call that a
/// signal interrupts goes on. Any thread may open links.
class PosixNetwork final : public Network {
 public:
  [[nodiscard]] Result<std::unique_ptr<DatagramLink>> open_datagrams(const Endpoint& local) override;
  [[nodiscard]] Result<std::unique_ptr<StreamListener>> listen(const Endpoint& local) override;
  [[nodiscard]] Result<std::unique_ptr<StreamLink>> connect(const Endpoint& remote) override;
};

}  // namespace takt::hw
