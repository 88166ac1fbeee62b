#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "serve/frames.h"
#include "serve/jogging.h"
#include "serve/routes.h"

namespace takt::serve {

/// One client of the protocol takt.v1 (docs/remote.md, "Streams"). Nothing is queued for it but answers: events are
/// read from the log of the cell as fast as the client takes them, values are made when the client is ready for a
/// frame. The thread of the server.
class StreamSession final : public Stream {
 public:
  static constexpr std::string_view kProtocol = "takt.v1";
  static constexpr std::size_t kMostMonitors = 64;
  static constexpr int kMostEvery = 100'000;

  /// @param peer  address of the client; all references outlive it
  StreamSession(const StreamServices& services, SharedSights& sights, Client client, std::string peer,
                std::function<void(Stream& stream)> gone);

  void opened(WebSocket& socket) override;
  void received(WebSocket::Kind kind, std::string_view message) override;
  void drained() override;
  void closed() override;
  void look() override;

  /// All messages of the protocol, in both directions.
  [[nodiscard]] static std::vector<MessageForm> messages();

 private:
  /// What a monitor shows of an arm.
  using ArmValue = device::JointVector ArmView::*;
  struct Monitor {
    int every = 1;
    std::shared_ptr<SharedWatch> watch;      ///< of a net or a channel
    std::size_t arm = 0;                     ///< index in the view
    ArmValue value = nullptr;                ///< of that arm
    std::optional<std::size_t> sensor = {};  ///< likewise an index
    bool poses = false;                      ///< of the whole cell
    PictureFormat format = {};               ///< of a camera
    std::shared_ptr<CameraFeed> feed = {};   ///< likewise
    std::int64_t asked = -1;                 ///< cycle at which its last picture was asked for
    std::int64_t last = -1;                  ///< cycle of the last value that was sent
  };
  using Handle = MessageResult (StreamSession::*)(ObjectReader& message);
  struct ClientMessage {
    MessageForm form;
    Handle handle;
  };
  static const std::vector<ClientMessage>& client_messages();

  MessageResult begin_events(ObjectReader& message);
  MessageResult add_monitor(ObjectReader& message);
  MessageResult set_rate(ObjectReader& message);
  MessageResult end_monitor(ObjectReader& message);
  MessageResult acknowledge(ObjectReader& message);
  MessageResult set_window(ObjectReader& message);
  MessageResult begin_jog(ObjectReader& message) { return jogging_->begin(message); }
  MessageResult move_jog(ObjectReader& message) { return jogging_->move(message); }
  MessageResult end_jog(ObjectReader& message) { return jogging_->end(message); }

  void read_camera_monitor(ObjectReader& message, Monitor& monitor) const;
  [[nodiscard]] std::expected<Monitor, MessageProblem> read_monitor(ObjectReader& message) const;
  void read_arm_monitor(ObjectReader& message, Monitor& monitor) const;
  void read_sensor_monitor(ObjectReader& message, Monitor& monitor) const;
  void say(const nlohmann::ordered_json& message);
  void say_monitored(std::uint32_t id, const Monitor& monitor);
  void say_problem(const std::string& op, const nlohmann::ordered_json& id, const MessageProblem& problem);
  void send_events();
  void send_frames();
  void send_values();
  void send_poses();
  void send_pictures();
  [[nodiscard]] bool has_room() const;
  [[nodiscard]] bool is_due(const Monitor& monitor, std::int64_t cycle) const;
  [[nodiscard]] bool poses_are_due() const;
  void end_monitors_of_ended_nets();

  StreamServices services_;
  SharedSights& sights_;
  Client client_;
  std::string peer_;
  std::function<void(Stream& stream)> gone_;
  WebSocket* socket_ = nullptr;  ///< null: not open
  std::shared_ptr<Jogging> jogging_;
  std::int64_t next_event_ = 0;  ///< to be sent; 0: none are wanted
  std::map<std::uint32_t, Monitor> monitors_;
  std::uint32_t last_frame_ = 0, acknowledged_ = 0, window_ = 8;
  bool poses_next_ = false;  ///< values and poses take turns
};

}  // namespace takt::serve
