#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "serve/follow_log.h"
#include "serve/jogging.h"
#include "serve/stream.h"

namespace takt::serve {

/// A client whose own core follows this cell: takt.core.v1, of programs in another process (docs/remote.md). Its
/// messages are texts; what the cell tells are records (cell/run/follow_record.h), several of them in one binary
/// message, each behind its size (u32). Nets are loaded by HTTP. The thread of the server.
class FollowSession final : public Stream {
 public:
  static constexpr std::string_view kProtocol = "takt.core.v1";

  /// @param peer  address of the client; all references outlive it
  FollowSession(const StreamServices& services, Client client, std::string peer,
                std::function<void(Stream& stream)> gone);

  void opened(WebSocket& socket) override;
  void received(WebSocket::Kind kind, std::string_view message) override;
  void drained() override { send_records(); }
  void closed() override;
  void look() override { send_records(); }

  static constexpr std::size_t kMostBytes = 256u << 10;  ///< of records in one message

 private:
  using Handle = MessageResult (FollowSession::*)(ObjectReader& message);
  void let_go();
  struct FollowMessage {
    std::string_view op;
    bool commands = true;  ///< only of a follower, and a sign of life of its lease
    Handle handle;
  };
  static std::span<const FollowMessage> follow_messages();

  MessageResult begin(ObjectReader& message);
  MessageResult rule(ObjectReader& message);
  MessageResult abort(ObjectReader& message);
  MessageResult unload(ObjectReader& message);
  MessageResult change_mode(ObjectReader& message);
  MessageResult stop(ObjectReader& message);
  MessageResult write_channel(ObjectReader& message);
  MessageResult set_tool(ObjectReader& message);
  MessageResult steps(ObjectReader& message);
  MessageResult touching(ObjectReader& message);
  MessageResult note(ObjectReader& message);
  MessageResult step_begun(ObjectReader& message);
  MessageResult judge(ObjectReader& message);
  MessageResult leave(ObjectReader& message);
  MessageResult alive(ObjectReader& message);

  /// Reads the tag, and gives the command to the cell if the message was good.
  MessageResult give(ObjectReader& message, FollowCommand command);
  [[nodiscard]] device::Arm* read_arm(ObjectReader& message) const;
  void say(const nlohmann::ordered_json& message);
  void say_problem(const std::string& op, const MessageProblem& problem);
  void send_records();

  StreamServices services_;
  HostedCell* hosted_;  ///< null: a program commands the cell, so nobody can follow it
  Client client_;
  std::string peer_;
  std::function<void(Stream& stream)> gone_;
  /// Null once it is closed; answers of the cell may come later.
  std::shared_ptr<WebSocket*> socket_ = std::make_shared<WebSocket*>(nullptr);
  std::uint32_t fence_ = 0;  ///< 0: it does not follow
};

}  // namespace takt::serve
