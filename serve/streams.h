#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "serve/follow_session.h"
#include "serve/foxglove_session.h"
#include "serve/stream_session.h"

namespace takt::serve {

/// All streams of a server: wakes them when the cell has news, and shares what they look at. The thread of the server,
/// but for what says otherwise.
class Streams {
 public:
  /// @param access, log, post, work_elsewhere  as in StreamServices. Before the cell runs.
  Streams(ServedCell& cell, Access& access, PictureMaker& pictures, std::function<void(const std::string& line)> log,
          std::function<void(std::function<void()> work)> post,
          std::function<bool(std::function<void()> job)> work_elsewhere);
  /// Once nothing of the server runs any more.
  ~Streams();
  Streams(const Streams&) = delete;
  Streams& operator=(const Streams&) = delete;

  /// A new client of takt.v1, or of another protocol that is in protocols().
  [[nodiscard]] std::shared_ptr<SocketUser> open(const std::string& protocol, const Client& client,
                                                 const std::string& peer);
  /// The sub-protocols that are spoken here; where a client offers several, the first of these counts.
  [[nodiscard]] static std::vector<std::string> protocols();
  /// How many this client has.
  [[nodiscard]] std::size_t count(const std::string& client) const;
  [[nodiscard]] const cell::CellScene& scene() const { return sights_.scene; }

 private:
  /// There is something new to look at. Any thread.
  void wake();
  void look();
  void forget_ended_nets();

  StreamServices services_;
  SharedSights sights_;
  std::map<Stream*, std::string> streams_;  ///< with the name of the client
  FoxgloveWorld foxglove_;
  std::vector<rcc::NetId> forget_;  ///< nets to be unloaded once they have ended
  std::atomic<bool> wanted_ = false, woken_ = false;
};

}  // namespace takt::serve
