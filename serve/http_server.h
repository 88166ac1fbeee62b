#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "core/base/diagnostics.h"

namespace takt::serve {

/// One request as it came, within the limits of the server. Names of headers are in lower case.
struct HttpRequest {
  std::string method, target, body;
  std::map<std::string, std::string, std::less<>> headers;
  std::string peer;  ///< address of the client

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

/// HTTP/1.1 on one thread of its own, by Boost.Beast (which nothing outside of http_server.cc sees). What exceeds a
/// limit is answered and closed; a client that is slow or silent costs its connection and nothing else.
class HttpServer {
 public:
  struct Options {
    std::string address = "127.0.0.1";
    unsigned short port = 0;  ///< 0: any that is free
    std::size_t header_bytes = 8u << 10, body_bytes = 4u << 20;
    std::size_t connections = 64;
    std::chrono::milliseconds request_time{10'000};  ///< for one whole request to come, or its answer to go
    std::chrono::milliseconds idle_time{60'000};     ///< of a connection between two requests
  };
  /// Called on the thread of the server for each request; it must not block. Errors of the transport itself (a request
  /// that is no HTTP, too large, too slow) come to `refuse`, whose answer is sent.
  struct Handlers {
    std::function<void(const HttpRequest& request, Respond respond)> handle;
    std::function<HttpResponse(int status, const std::string& detail)> refuse;
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

 private:
  HttpServer() = default;
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace takt::serve
