#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "serve/access.h"
#include "serve/http_server.h"
#include "serve/panel_files.h"

namespace takt::serve {

class Api;
class ServedCell;

/// A hosted cell on the network: HTTP server, access and routes together. The cell is run by whoever owns it, and
/// outlives the server. Thread: any one.
class Server {
 public:
  struct Options {
    HttpServer::Options http = {};
    std::vector<Token> tokens = {};                         ///< needed for every address that is not loopback
    std::vector<std::string> names = {};                    ///< further names of this machine, for Host, without port
    std::vector<std::string> origins = {};                  ///< pages elsewhere that may use the server, "https://a.b"
    PanelFiles page = {};                                   ///< what "/" hands out
    std::function<void(const std::string& line)> log = {};  ///< from any thread
  };
  /// All that is wrong with options, before a cell is built. Realtime: setup.
  [[nodiscard]] static Diagnostics check(const Options& options);
  /// @return the server, which answers from now on; or why it cannot. Realtime: setup.
  [[nodiscard]] static Result<std::unique_ptr<Server>> open(ServedCell& cell, const Options& options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] unsigned short port() const;
  /// That are open just now, those of streams included.
  [[nodiscard]] std::size_t connections() const;
  /// "http://127.0.0.1:8700"
  [[nodiscard]] std::string url() const;

 private:
  Server() = default;
  std::string address_;
  std::unique_ptr<Api> api_;
  std::unique_ptr<HttpServer> http_;
};

/// Whether only this machine reaches an IP address.
[[nodiscard]] bool is_loopback(const std::string& address);

}  // namespace takt::serve
