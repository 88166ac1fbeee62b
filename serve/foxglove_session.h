#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "serve/stream.h"

namespace takt::serve {

/// What clients of Foxglove's protocol get that never changes. Setup.
struct FoxgloveWorld {
  explicit FoxgloveWorld(const ServedCell& cell);
  std::string session;  ///< differs each time a server is started
  std::string scene;    ///< a message foxglove.SceneUpdate
};

/// One client of Foxglove's WebSocket protocol (docs/remote.md, "Foxglove"): it looks, and commands nothing. Values
/// that it is too slow for are left out; lines of the log are not. The thread of the server.
class FoxgloveSession final : public Stream {
 public:
  /// The names of the protocol that are spoken here, the newer one first.
  static constexpr std::array<std::string_view, 2> kProtocols = {"foxglove.sdk.v1", "foxglove.websocket.v1"};

  FoxgloveSession(const StreamServices& services, SharedSights& sights, const FoxgloveWorld& world, std::string peer,
                  std::function<void(Stream& stream)> gone);

  void opened(WebSocket& socket) override;
  void received(WebSocket::Kind kind, std::string_view message) override;
  void drained() override;
  void closed() override;
  void look() override;

 private:
  /// What it offers; the first arm is kFirstArm, the next one the number after that.
  enum Channel : std::uint32_t { kTransforms = 1, kScene = 2, kLog = 3, kFirstArm = 4 };
  [[nodiscard]] std::uint32_t channels() const;
  void advertise();
  void subscribe(const nlohmann::ordered_json& message);
  void unsubscribe(const nlohmann::ordered_json& message);
  void say_status(const std::string& text);
  void say(const nlohmann::ordered_json& message);
  void send_data(std::uint32_t channel, Nanoseconds time, std::string_view data);
  void send_time(Nanoseconds time);
  void send_values();
  void send_log();
  [[nodiscard]] std::string transforms(Nanoseconds time);
  [[nodiscard]] std::string joint_states(std::size_t arm, Nanoseconds time) const;

  StreamServices services_;
  SharedSights& sights_;
  const FoxgloveWorld& world_;
  std::string peer_;
  std::function<void(Stream& stream)> gone_;
  WebSocket* socket_ = nullptr;
  std::map<std::uint32_t, std::uint32_t> subscriptions_;  ///< by channel: the client's number
  std::int64_t last_ = -1;                                ///< cycle of the last values
  std::int64_t next_event_ = 0;                           ///< for the log
};

}  // namespace takt::serve
