#include <chrono>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include "cell/run/session.h"
#include "core/net/description.h"
#include "tests/serve/served.h"

namespace takt::serve::test {
namespace {

using namespace std::chrono_literals;

const device::ModelLibrary& own_models() {
  static const device::ModelLibrary models({"models"});
  return models;
}

}  // namespace

Json Answer::json() const { return Json::parse(body, nullptr, false); }

Wire::Wire(unsigned short port, const std::string& text) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  send(text);
}

Wire::~Wire() { close(socket_); }

void Wire::send(const std::string& text) const {
  if (!text.empty()) (void)::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
}

std::string Wire::read_all() const {
  std::string text;
  char chunk[65536];
  for (ssize_t n = 0; (n = recv(socket_, chunk, sizeof chunk, 0)) > 0;) text.append(chunk, static_cast<std::size_t>(n));
  return text;
}

Answer Client::ask(const std::string& method, const std::string& path, const std::string& body) const {
  std::map<std::string, std::string> all = {{"Host", fmt::format("127.0.0.1:{}", port)}, {"Connection", "close"}};
  if (!body.empty()) all["Content-Type"] = "application/json";
  if (!body.empty() || method == "POST" || method == "PUT") all["Content-Length"] = std::to_string(body.size());
  if (fence != 0) all["Takt-Fence"] = std::to_string(fence);
  for (const auto& [name, value] : headers) all[name] = value;
  std::string text = fmt::format("{} {} HTTP/1.1\r\n", method, path);
  for (const auto& [name, value] : all) text += fmt::format("{}: {}\r\n", name, value);
  const std::string came = Wire(port, text + "\r\n" + body).read_all();
  Answer answer;
  const std::size_t end = came.find("\r\n\r\n");
  if (end == std::string::npos || !came.starts_with("HTTP/1.1 ")) return answer;
  answer.status = std::stoi(came.substr(9, 3));
  answer.body = came.substr(end + 4);
  for (std::size_t at = came.find("\r\n") + 2; at < end;) {
    const std::size_t stop = came.find("\r\n", at), colon = came.find(": ", at);
    answer.headers[came.substr(at, colon - at)] = came.substr(colon + 2, stop - colon - 2);
    at = stop + 2;
  }
  return answer;
}

void Client::take_lease(const Json& how) {
  const Answer answer = post("/v1/lease", how);
  ASSERT_EQ(answer.status, 201) << answer.body;
  fence = answer.json()["fence"];
}

std::string Client::state(int net) const {
  const Json json = get(fmt::format("/v1/nets/{}", net)).json();
  return json.value("state", "unknown");
}

int Client::load(const Json& net) const {
  const Answer answer = post("/v1/nets", {{"net", net}});
  EXPECT_EQ(answer.status, 202) << answer.body;
  if (answer.status != 202) return 0;
  const int id = answer.json()["net"];
  while (state(id) == "Loading") std::this_thread::sleep_for(1ms);
  return id;
}

Served::Served(bool realtime, const Server::Options& options, const std::string& file, const std::string& recordings) {
  HostedCell::Options hosting;
  hosting.run.realtime = realtime;
  hosting.recordings = recordings;
  auto opened = HostedCell::open(file, own_models(), hosting);
  if (!opened) throw std::runtime_error(opened.error().to_string());
  cell = std::move(*opened);
  auto listening = Server::open(*cell, options);
  if (!listening) throw std::runtime_error(listening.error().to_string());
  server = std::move(*listening);
  thread_ = std::jthread([this] { report = cell->run(); });
  await_connection();
}

Served::~Served() {
  cell->stop();
  thread_.join();
  EXPECT_FALSE(report.diagnostics.has_errors()) << report.diagnostics.to_string();
  server.reset();
}

void Served::await_connection() const {
  while (!cell->view().connected) std::this_thread::sleep_for(1ms);
}

Json Served::motion() {
  auto session = cell::Session::open("scenarios/touch.json", own_models());
  if (!session) throw std::runtime_error(session.error().to_string());
  return net_to_json((*session)->nets().at(0).net);
}

}  // namespace takt::serve::test
