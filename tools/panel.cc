#include "tools/panel.h"

#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "serve/access.h"

namespace takt::tools {

std::filesystem::path panel_folder(const Common& common) { return common.root / "panel" / "dist"; }

void tell_page(const std::string& url, const serve::PanelFiles& page) {
  if (page.complete()) {
    fmt::print(stderr, "page: {}\n", url);
  } else {
    fmt::print(stderr, "page: not built; open {} to see how\n", url);
  }
}

Result<std::unique_ptr<RunPanel>> RunPanel::open(cell::Session& session, cell::RunOptions& options, unsigned short port,
                                                 const Common& common) {
  std::unique_ptr<RunPanel> panel(new RunPanel(session, options));
  const std::string token = serve::random_secret();
  const serve::Server::Options serving{.http = {.port = port},
                                       .tokens = {{.role = serve::Role::kOperator, .name = "page", .secret = token}},
                                       .page = serve::PanelFiles::read(panel_folder(common)),
                                       .log = [](const std::string& line) { fmt::print(stderr, "{}\n", line); }};
  auto server = serve::Server::open(panel->run_, serving);
  if (!server) return std::unexpected(std::move(server.error()));
  panel->server_ = std::move(*server);
  // Behind '#': a browser keeps that for itself, so the token stands in no request and no log.
  tell_page(fmt::format("{}/#token={}", panel->server_->url(), token), serving.page);
  fmt::print(stderr, "the program begins when somebody starts it there; Ctrl-C ends\n");
  return panel;
}

void RunPanel::ended(const cell::RunReport& report, const cell::RunOptions& options) {
  constexpr std::chrono::milliseconds kLook{100};
  constexpr int kAlone = 20;  // looks: a page that is loaded anew is gone for a moment
  run_.ended(report);
  const auto interrupted = [&] { return options.interrupt != nullptr && options.interrupt->load() > 0; };
  if (!interrupted() && server_->connections() > 0) fmt::print(stderr, "the page shows the end; close it, or Ctrl-C\n");
  for (int alone = 0; alone < kAlone && !interrupted(); std::this_thread::sleep_for(kLook))
    alone = server_->connections() > 0 ? 0 : alone + 1;
  server_.reset();
}

}  // namespace takt::tools
