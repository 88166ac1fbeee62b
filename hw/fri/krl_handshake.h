#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hw/fri/protocol/packet.h"

namespace takt::hw::fri {

/// What the driver asks of the KRL program.
struct KrlRequest {
  State state = State::kMonitor;  ///< kMonitor or kCommand
  Control control = Control::kPosition;
  int number = 0;  ///< another one for each request, so that none is served twice
};

/// Says to a KRL program, in the words of its convention, which state and control mode are wanted. All words are states
/// and not events, so a lost datagram only delays. One thread. Realtime: cyclic, no allocation.
class KrlHandshake {
 public:
  virtual ~KrlHandshake() = default;
  /// Fills what the next command carries. @param seen  what KRL said last
  virtual void fill(const KrlRequest& request, const Measurement& seen, KrlValues& out) = 0;
  /// A number that KRL has not served yet, to begin with.
  [[nodiscard]] virtual int first_number(const Measurement& /*seen*/) const { return 1; }
};

/// By the name of the convention. @return null: there is none. Realtime: setup.
[[nodiscard]] std::unique_ptr<KrlHandshake> make_krl_handshake(std::string_view convention);

/// "takt", "fri_control", "ros_control". The other programs know less than the driver asks for, or more than it says:
/// they are there for clients of others, at the emulator (krl_conventions()).
[[nodiscard]] const std::vector<std::string>& driver_conventions();

}  // namespace takt::hw::fri
