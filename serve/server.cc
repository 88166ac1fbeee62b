#include "serve/server.h"

#include <future>

#include <fmt/format.h>

#include "serve/api.h"

namespace takt::serve {
namespace {

/// An address as it stands in a URL.
std::string in_url(const std::string& address) {
  return address.find(':') == std::string::npos ? address : "[" + address + "]";
}

std::vector<std::string> hosts_of(const Server::Options& options, unsigned short port) {
  std::vector<std::string> names = options.names;
  names.push_back(in_url(options.http.address));
  if (is_loopback(options.http.address)) names.insert(names.end(), {"localhost"});
  std::vector<std::string> hosts;
  for (const std::string& name : names) {
    hosts.push_back(fmt::format("{}:{}", name, port));
    if (port == 80) hosts.push_back(name);
  }
  for (const std::string& name : options.names) hosts.push_back(name);  // behind a proxy, which has a port of its own
  return hosts;
}

}  // namespace

bool is_loopback(const std::string& address) { return address.starts_with("127.") || address == "::1"; }

Diagnostics Server::check(const Options& options) {
  Diagnostics wrong;
  if (!is_loopback(options.http.address) && options.tokens.empty())
    wrong.error(Code::kRequires, "--tokens",
                fmt::format("'{}' can be reached by others, and there are no tokens", options.http.address),
                "Give a token file with --tokens, or listen at 127.0.0.1");
  for (const std::string& origin : options.origins) wrong.append(check_origin("--origin", origin));
  for (const std::string& name : options.names) wrong.append(check_host_name("--host", name));
  return wrong;
}

Result<std::unique_ptr<Server>> Server::open(ServedCell& cell, const Options& options) {
  if (Diagnostics wrong = check(options); wrong.has_errors()) return std::unexpected(std::move(wrong));
  std::unique_ptr<Server> server(new Server);
  server->address_ = options.http.address;
  // The port, and with it the hosts, are known once the server listens: requests wait until then.
  auto ready = std::make_shared<std::promise<Api*>>();
  auto api = std::make_shared<std::shared_future<Api*>>(ready->get_future().share());
  auto http = HttpServer::open(
      options.http,
      {.handle = [api](const HttpRequest& request, const Respond& respond) { api->get()->handle(request, respond); },
       .refuse = [](int status, const std::string& detail) { return problem(status, detail); },
       .upgrade = [api](const HttpRequest& request) { return api->get()->upgrade(request); }});
  if (!http) return std::unexpected(std::move(http.error()));
  server->http_ = std::move(*http);
  Access access(
      {.tokens = options.tokens, .hosts = hosts_of(options, server->http_->port()), .origins = options.origins});
  server->api_ = std::make_unique<Api>(
      cell, std::move(access), options.page, options.log ? options.log : [](const std::string&) {},
      server->http_->poster());
  ready->set_value(server->api_.get());
  return server;
}

Server::~Server() {
  http_.reset();  // no request comes any more
}

unsigned short Server::port() const { return http_->port(); }
std::size_t Server::connections() const { return http_->connections(); }
std::string Server::url() const { return fmt::format("http://{}:{}", in_url(address_), port()); }

}  // namespace takt::serve
