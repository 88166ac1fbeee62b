#pragma once

#include <chrono>
#include <cstddef>
#include <expected>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/diagnostics.h"

namespace takt::serve {

/// One request as it came, within the limits of the server. Names of headers are in lower case.
struct HttpRequest {
  std::string method, target, body;
  std::map<std::string, std::string, std::less<>> headers;
  std::string peer;      ///< address of the client
  bool crowded = false;  ///< it came beyond the limit of connections: only what must never be refused is answered

  /// Empty if it is not there.
  [[nodiscard]] std::string header(std::string_view name) const;
};

struct HttpResponse {
  int status = 200;
  std::string content_type = "application/json";
  std::string body = {};
  std::map<std::string, std::string, std::less<>> headers = {};
};

/// Gives the answer, once, from any thread. The connection may be gone by then.
using Respond = std::function<void(HttpResponse)>;

/// A connection that has become a WebSocket. Messages go out in order; they are never compressed. For the thread of the
/// server alone.
class WebSocket {
 public:
  enum class Kind { kText, kBinary };
  virtual ~WebSocket() = default;
  virtual void send(Kind kind, std::string message) = 0;
  /// Messages that are not with the operating system yet. While there are kMostWaiting of them, the server reads
  /// nothing from this connection, so that what a client asks for cannot pile up.
  [[nodiscard]] virtual std::size_t waiting() const = 0;
  /// Says why (RFC 6455: code, and at most 123 bytes) after what waits, and ends.
  virtual void close(unsigned short code, const std::string& reason) = 0;
  static constexpr std::size_t kMostWaiting = 256;
};

/// Who talks by a WebSocket. All calls come on the thread of the server, none after closed().
class SocketUser {
 public:
  virtual ~SocketUser() = default;
  /// It may be used until closed().
  virtual void opened(WebSocket& socket) = 0;
  virtual void received(WebSocket::Kind kind, std::string_view message) = 0;
  /// Nothing waits to be sent any more.
  virtual void drained() = 0;
  virtual void closed() = 0;
};

/// How a request goes on as a WebSocket.
struct Upgrade {
  std::string protocol;  ///< the sub-protocol that was chosen
  std::shared_ptr<SocketUser> user;
};

/// HTTP/1.1 and WebSocket on one thread of its own, by Boost.Beast (which nothing outside of http_server.cc sees). What
/// exceeds a limit is answered and closed; a client that is slow or silent costs its connection and nothing else.
class HttpServer {
 public:
  struct Options {
    std::string address = "127.0.0.1";
    unsigned short port = 0;  ///< 0: any that is free
    std::size_t header_bytes = 8u << 10, body_bytes = 4u << 20;
    std::size_t connections = 64;  ///< as many again may ask for what must never be refused (HttpRequest::crowded)
    std::chrono::milliseconds request_time{10'000};  ///< for one whole request to come, or its answer to go
    std::chrono::milliseconds idle_time{60'000};     ///< of a connection between two requests
    std::size_t message_bytes = 64u << 10;           ///< of a WebSocket's message from a client
    /// After which a WebSocket ends whose client takes nothing, or does not answer a ping.
    std::chrono::milliseconds silence{20'000};
  };
  /// Called on the thread of the server for each request; it must not block. Errors of the transport itself (a request
  /// that is no HTTP, too large, too slow) come to `refuse`, whose answer is sent.
  struct Handlers {
    std::function<void(const HttpRequest& request, Respond respond)> handle;
    std::function<HttpResponse(int status, const std::string& detail)> refuse;
    /// A request to become a WebSocket. @return how it goes on, or the answer that refuses it. Empty: there are none
    std::function<std::expected<Upgrade, HttpResponse>(const HttpRequest& request)> upgrade = {};
  };

  /// Listens and begins to answer. @return the server, or why it cannot: an address that is none or not of this
  /// machine, a port that is taken. Realtime: setup.
  [[nodiscard]] static Result<std::unique_ptr<HttpServer>> open(const Options& options, Handlers handlers);
  /// Closes all connections and waits for the thread.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] unsigned short port() const;
  [[nodiscard]] std::size_t connections() const;
  /// Has something done on the thread of the server. It may be kept and called from any thread, longer than the server
  /// lives; then nothing happens.
  [[nodiscard]] std::function<void(std::function<void()> work)> poster() const;

 private:
  HttpServer() = default;
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace takt::serve
