#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/base/object_reader.h"
#include "serve/jog_net.h"
#include "serve/stream.h"

namespace takt::serve {

/// Why a message cannot be carried out.
struct MessageProblem {
  int status = 422;
  std::string detail;
  Diagnostics diagnostics = {};
};
using MessageResult = std::expected<void, MessageProblem>;

/// What one client moves by hand. The thread of the server.
class Jogging : public std::enable_shared_from_this<Jogging> {
 public:
  static constexpr std::size_t kMost = 8;
  using Send = std::function<void(const nlohmann::ordered_json& message)>;
  /// @param fail  a problem of a message `op` that comes later, of a jogging
  using Fail = std::function<void(const std::string& op, std::uint32_t jog, const MessageProblem& problem)>;

  Jogging(const StreamServices& services, Client client, Send send, Fail fail);

  [[nodiscard]] MessageResult begin(ObjectReader& message);
  [[nodiscard]] MessageResult move(ObjectReader& message);
  [[nodiscard]] MessageResult end(ObjectReader& message);
  /// There is something new to see: tells what has begun and ended.
  void look();
  /// The connection is gone: everything comes to rest.
  void close();

 private:
  struct Jog {
    JogRequest request;
    std::uint32_t fence = 0;
    device::Channel* channel = nullptr;
    int joints = 0;
    rcc::NetId net = 0;  ///< 0: it is being made
    rcc::RequestId start = 0;
    std::int64_t events_from = 1;  ///< where to look for what became of the start
    std::int64_t sequence = -1;    ///< of the last move
    bool runs = false, released = false;
  };
  void made(std::uint32_t number, const Result<rcc::NetId>& net);
  void release(Jog& jog);
  /// @return false: it has been refused
  [[nodiscard]] bool look_for_start(std::uint32_t number, Jog& jog);
  [[nodiscard]] bool has_ended(std::uint32_t number, const Jog& jog) const;
  [[nodiscard]] std::string why_ended(const Jog& jog) const;

  StreamServices services_;
  Client client_;
  Send send_;
  Fail fail_;
  std::map<std::uint32_t, Jog> jogs_;
  bool closed_ = false;
};

/// A number that a client chose for something: 0 to 2^32 - 1.
[[nodiscard]] std::uint32_t read_number(ObjectReader& message, std::string_view key);

}  // namespace takt::serve
