#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "hw/emulators/rtde/controller.h"
#include "hw/emulators/rtde/session.h"
#include "hw/wire/network.h"

namespace takt::hw::rtde {

/// Ports of a UR controller. Clients have them built in, so each controller needs an address of its own.
inline constexpr std::uint16_t kDashboardPort = 29999, kPrimaryPort = 30001, kSecondaryPort = 30002,
                               kRealtimePort = 30003, kRtdePort = 30004;

/// Where an emulated controller is reached: all of its ports at one address. One thread.
class Front {
 public:
  /// Connections of one port; more are closed at once.
  static constexpr std::size_t kMostClients = 32;
  /// A client that reads nothing for so long, while there is something for it, is closed.
  static constexpr Nanoseconds kAnswerTimeout = 5 * kSecond;

  /// @param host  127.0.0.1, or another address of this machine. `network` and `controller` outlive the front.
  /// @return the front, or why a port cannot be opened. Realtime: setup.
  [[nodiscard]] static Result<std::unique_ptr<Front>> open(hw::Network& network, std::uint32_t host,
                                                           Controller& controller);

  /// Accepts clients, takes what they have sent, and sends what waits.
  void exchange();
  /// A frame of the controller is over.
  void end_frame();
  /// Cuts every connection, as a controller does that restarts.
  void drop_clients();
  [[nodiscard]] std::size_t clients() const;

 private:
  struct Client {
    std::unique_ptr<hw::StreamLink> link;
    std::unique_ptr<Session> session;
    Nanoseconds stuck_since = -1;
  };
  struct Port {
    std::unique_ptr<hw::StreamListener> listener;
    std::unique_ptr<Service> service;
    std::vector<Client> clients;
  };

  explicit Front(Controller& controller) : controller_(controller) {}
  void add(std::uint16_t port, std::unique_ptr<Service> service, hw::Network& network, std::uint32_t host,
           Diagnostics& diagnostics);
  void accept(Port& port);
  static void receive(Client& client);
  [[nodiscard]] bool send(Client& client) const;

  Controller& controller_;
  std::vector<Port> ports_;
};

}  // namespace takt::hw::rtde
