#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "core/base/diagnostics.h"

namespace takt::app {

/// The server cannot be reached any more, or did not answer.
class LinkError final : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A connection to takt serve, by HTTP and by WebSocket, with Boost.Beast, which no other file of app sees. One thread
/// of its own reads and writes the WebSocket and gives signs of life. Realtime: setup.
class ServerLink {
 public:
  struct Options {
    std::string url;                             ///< "http://HOST:PORT"
    std::filesystem::path token;                 ///< file with a token and nothing else, mode 0600; empty: none
    std::chrono::milliseconds patience{20'000};  ///< for an answer
  };
  struct Answer {
    int status = 0;
    std::string body;
  };
  struct Message {
    bool binary = false;
    std::string bytes;
  };

  /// @return the link; or what is wrong with the options, or why the server cannot be reached, at "--core"
  [[nodiscard]] static Result<std::unique_ptr<ServerLink>> open(const Options& options);
  ~ServerLink();
  ServerLink(const ServerLink&) = delete;
  ServerLink& operator=(const ServerLink&) = delete;

  /// One request. Any thread, one at a time. Throws LinkError. @param fence  0: without
  [[nodiscard]] Answer ask(const std::string& method, const std::string& target, const std::string& body = {},
                           std::uint32_t fence = 0);

  /// Opens the WebSocket. Once. @return why not
  [[nodiscard]] Diagnostics connect(const std::string& protocol);
  /// From now on this text is sent so often, whatever else happens.
  void repeat(const std::string& text, std::chrono::milliseconds every);
  void send(std::string text);
  /// The next message. Throws LinkError when the connection is gone, or nothing came for Options::patience.
  [[nodiscard]] Message receive();
  /// The same, without waiting; nothing: there is none.
  [[nodiscard]] std::optional<Message> poll();

 private:
  ServerLink() = default;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::app
