// Any bytes as messages of a stream, one a line, lead to answers or to the end of that connection. By hand, as it needs
// the simulation: docs/testing.md.
#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "serve/follow_session.h"
#include "serve/stream_session.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"
#include "tests/support/json_mutator.h"

namespace takt {
namespace {

using serve::WebSocket;

/// Takes what is sent; every text is a JSON object with an op.
class Listener final : public WebSocket {
 public:
  void send(Kind kind, std::string message) override {
    if (kind != Kind::kText) return;
    const auto json = parse_json(message);
    test::demand(json.has_value() && json->is_object() && json->contains("op"), "an answer has an op");
    if (json->at("op") == "problem") test::demand(json->contains("title"), "a problem has a title");
  }
  [[nodiscard]] std::size_t waiting() const override { return 0; }
  void close(unsigned short code, const std::string& reason) override {
    test::demand(code >= 1000 && !reason.empty(), "the end of a stream has a reason");
    closed = true;
  }
  bool closed = false;
};

/// A cell that nobody runs, and what streams use of a server.
struct Stage {
  std::unique_ptr<serve::HostedCell> cell;
  serve::Access access{{.tokens = {}, .hosts = {}, .origins = {}, .requests_per_second = 1e12, .burst = 1e12}};
  std::unique_ptr<serve::StreamServices> services;
  std::unique_ptr<serve::SharedSights> sights;

  Stage() {
    auto opened = serve::HostedCell::open("scenarios/touch.json", device::ModelLibrary({"models"}), {});
    test::demand(opened.has_value(), "the cell is there");
    cell = std::move(*opened);
    services = std::make_unique<serve::StreamServices>(
        serve::StreamServices{.cell = *cell,
                              .access = access,
                              .log = [](const std::string&) {},
                              .post = [](const std::function<void()>& work) { work(); },
                              .work_elsewhere = [](const std::function<void()>&) { return false; },
                              .forget_later = [](rcc::NetId) {}});
    sights.reset(new serve::SharedSights{
        .view = cell->view(), .watches = serve::WatchPool(cell->core()), .scene = cell::CellScene(cell->built())});
  }
};

void talk(serve::SocketUser& user, std::string_view text) {
  Listener socket;
  user.opened(socket);
  while (!text.empty() && !socket.closed) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    user.received(WebSocket::Kind::kText, text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  user.closed();
}

void say_all(std::string_view text) {
  static Stage stage;
  (void)stage.cell->lease().grant(0);
  const serve::Client client{.role = serve::Role::kOperator, .name = "fuzz"};
  const auto gone = [](serve::Stream&) {};
  talk(*std::make_shared<serve::StreamSession>(*stage.services, *stage.sights, client, "peer", gone), text);
  talk(*std::make_shared<serve::FollowSession>(*stage.services, client, "peer", gone), text);
}

std::vector<std::string> message_words() {
  std::vector<std::string> words;
  for (const serve::MessageForm& form : serve::StreamSession::messages()) {
    words.push_back(form.op);
    for (const serve::Field& field : form.fields) words.push_back(field.name);
  }
  for (const char* one : {"follow", "rule", "abort", "unload", "mode", "stop", "channel", "tool", "steps", "touching",
                          "note", "step_begun", "judge", "alive", "tag", "condition", "action", "states", "arm"})
    words.emplace_back(one);
  return words;
}

const std::vector<std::string>& all_words() {
  static const std::vector<std::string> words = message_words();
  return words;
}

}  // namespace
}  // namespace takt

namespace takt::test {

const FuzzTarget& fuzz_target() {
  static const FuzzTarget target{.words = all_words(),
                                 .load = say_all,
                                 .share = 0.8,
                                 .mutate = [](std::string_view input, Random& random) -> std::optional<std::string> {
                                   const auto document = parse_json(input.substr(0, input.find('\n')));
                                   if (!document) return std::nullopt;
                                   std::string text = mutated_json(*document, all_words(), random);
                                   if (const auto rest = input.find('\n'); rest != std::string_view::npos)
                                     text += input.substr(rest);
                                   return text;
                                 }};
  return target;
}

}  // namespace takt::test
