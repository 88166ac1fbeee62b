#pragma once

#include <map>
#include <memory>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "serve/hosted_cell.h"
#include "serve/server.h"

namespace takt::serve::test {

using Json = nlohmann::ordered_json;

/// What a server has answered.
struct Answer {
  int status = 0;  ///< 0: nothing came
  std::map<std::string, std::string> headers;
  std::string body;
  [[nodiscard]] Json json() const;
};

/// A TCP connection to a port of this machine, with what was sent to it at once.
class Wire {
 public:
  explicit Wire(unsigned short port, const std::string& text = {});
  ~Wire();
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;
  void send(const std::string& text) const;
  /// Until the other side closes.
  [[nodiscard]] std::string read_all() const;

 private:
  int socket_ = -1;
};

/// One request on a connection of its own.
struct Client {
  unsigned short port = 0;
  std::map<std::string, std::string> headers = {};
  std::uint32_t fence = 0;

  [[nodiscard]] Answer ask(const std::string& method, const std::string& path, const std::string& body = {}) const;
  [[nodiscard]] Answer get(const std::string& path) const { return ask("GET", path); }
  [[nodiscard]] Answer post(const std::string& path, const Json& body = Json::object()) const {
    return ask("POST", path, body.dump());
  }
  void take_lease(const Json& how = Json::object());
  /// LOAD, and waits for Ready or Rejected. @return the number
  [[nodiscard]] int load(const Json& net) const;
  [[nodiscard]] std::string state(int net) const;
};

/// A cell that is served, on a thread, until the end of the test.
class Served {
 public:
  /// @param file  scenario or cell; @param recordings  folder of recordings; empty: none
  explicit Served(bool realtime, const Server::Options& options = {}, const std::string& file = "scenarios/touch.json",
                  const std::string& recordings = {});
  ~Served();
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  [[nodiscard]] Client client() const { return {.port = server->port()}; }
  [[nodiscard]] static Json motion();  ///< a net: the first motion of the scenario
  void await_connection() const;

  std::unique_ptr<HostedCell> cell;
  std::unique_ptr<Server> server;
  cell::RunReport report;

 private:
  std::jthread thread_;
};

}  // namespace takt::serve::test
