#pragma once

#include <map>
#include <memory>
#include <string>

#include "hw/wire/network.h"

namespace takt::hw::rtde {

/// The connections that programs have opened to other machines, by name. One thread.
class ScriptSockets {
 public:
  static constexpr std::size_t kMost = 32, kLargestBuffer = 1u << 16;

  /// @param network  null: none can be opened
  explicit ScriptSockets(hw::Network* network) : network_(network) {}

  /// Begins to connect, in place of one of this name. @return false: it cannot be.
  bool open(const std::string& host, int port, const std::string& name);
  void close(const std::string& name) { sockets_.erase(name); }
  void close_all() { sockets_.clear(); }
  /// kFailed for a name that is not open.
  [[nodiscard]] hw::StreamLink::State state(const std::string& name);
  bool send(const std::string& name, std::string_view bytes);
  /// What has come and was not taken yet; empty for a name that is not open.
  std::string& received(const std::string& name);

 private:
  struct Socket {
    std::unique_ptr<hw::StreamLink> link;
    std::string in, out;
  };
  void pump(Socket& socket);

  hw::Network* network_;
  std::map<std::string, Socket> sockets_;
  std::string none_;
};

}  // namespace takt::hw::rtde
