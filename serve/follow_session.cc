#include "serve/follow_session.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/keys_of.h"
#include "serve/cell_json.h"
#include "serve/hosted_cell.h"
#include "serve/routes.h"
#include "serve/rule_reader.h"

namespace takt::serve {
namespace {

using FollowJson = nlohmann::ordered_json;

constexpr unsigned short kNoText = 1003, kWrongJson = 1007, kUnknownMessage = 1008;
constexpr std::size_t kMessageDepth = 16, kMostOnTheWay = 16;
constexpr std::int64_t kMostStepsAtOnce = 100'000;
constexpr Range kTags{.low = 0, .high = 4294967295.0};

std::unexpected<MessageProblem> refuse_message(int status, std::string detail, Diagnostics diagnostics = {}) {
  return std::unexpected(
      MessageProblem{.status = status, .detail = std::move(detail), .diagnostics = std::move(diagnostics)});
}

FollowJson results_json(const std::vector<cell::ExpectationResult>& results) {
  FollowJson list = FollowJson::array();
  for (const cell::ExpectationResult& one : results)
    list.push_back({{"name", one.name},
                    {"kind", one.kind},
                    {"passed", one.passed},
                    {"judged", one.judged},
                    {"measured", one.measured},
                    {"value", one.value},
                    {"unit", one.unit}});
  return list;
}

}  // namespace

FollowSession::FollowSession(const StreamServices& services, Client client, std::string peer,
                             std::function<void(Stream& stream)> gone)
    : services_(services),
      hosted_(services.cell.hosted()),
      client_(std::move(client)),
      peer_(std::move(peer)),
      gone_(std::move(gone)) {}

std::span<const FollowSession::FollowMessage> FollowSession::follow_messages() {
  using Self = FollowSession;
  static constexpr std::array<FollowMessage, 15> kMessages = {{{"follow", false, &Self::begin},
                                                               {"rule", true, &Self::rule},
                                                               {"abort", true, &Self::abort},
                                                               {"unload", true, &Self::unload},
                                                               {"mode", true, &Self::change_mode},
                                                               {"stop", false, &Self::stop},
                                                               {"channel", true, &Self::write_channel},
                                                               {"tool", true, &Self::set_tool},
                                                               {"steps", true, &Self::steps},
                                                               {"touching", true, &Self::touching},
                                                               {"note", true, &Self::note},
                                                               {"step_begun", true, &Self::step_begun},
                                                               {"judge", true, &Self::judge},
                                                               {"leave", true, &Self::leave},
                                                               {"alive", true, &Self::alive}}};
  return kMessages;
}

void FollowSession::opened(WebSocket& socket) {
  *socket_ = &socket;
  say({{"op", "hello"}, {"protocol", kProtocol}, {"name", client_.name}, {"role", name_of(client_.role)}});
}

/// Nobody follows any more, and whoever comes next may. What this client started need not wait for its silence.
void FollowSession::let_go() {
  if (fence_ == 0) return;
  hosted_->between_cycles([&cell = *hosted_](cell::CellRun&) { cell.set_touching({}); });
  hosted_->follow_log().end();
  if (services_.cell.lease().release(fence_))
    services_.log(fmt::format("'{}' is gone, and with that the lease, fence {}", client_.name, fence_));
  fence_ = 0;
  hosted_->wake();
}

void FollowSession::closed() {
  *socket_ = nullptr;
  let_go();
  gone_(*this);
}

void FollowSession::received(WebSocket::Kind kind, std::string_view text) {
  WebSocket& socket = **socket_;
  if (kind != WebSocket::Kind::kText) return socket.close(kNoText, "messages of clients are texts");
  const auto json = parse_json(text, {.bytes = text.size(), .depth = kMessageDepth});
  if (!json || !json->is_object()) return socket.close(kWrongJson, "a message is a JSON object");
  Diagnostics diagnostics;
  ObjectReader message(*json, "", diagnostics);
  const std::string op = message.text("op");
  const auto known = std::ranges::find(follow_messages(), op, &FollowMessage::op);
  if (known == follow_messages().end()) return socket.close(kUnknownMessage, "unknown message");
  if (op != "stop" && services_.access.too_fast(peer_))
    return say_problem(op, {.status = 429, .detail = "too many messages a second", .diagnostics = {}});
  if (known->commands && !services_.cell.lease().renew(fence_))
    return say_problem(op, {.status = 409, .detail = "this client does not follow, or its lease is over"});
  if (const auto done = (this->*known->handle)(message); !done) say_problem(op, done.error());
}

MessageResult FollowSession::begin(ObjectReader& message) {
  const auto fence = static_cast<std::uint32_t>(message.integer("fence", {}, kTags));
  message.finish();
  if (message.diagnostics().has_errors())
    return refuse_message(422, "the message cannot be read", message.diagnostics());
  if (client_.role != Role::kOperator) return refuse_message(403, "observers may look and stop, and nothing else");
  if (hosted_ == nullptr) return refuse_message(409, "a program commands this cell");
  HostedCell& cell = *hosted_;
  if (fence_ != 0) return refuse_message(409, "this client follows already");
  if (!cell.lease().renew(fence)) return refuse_message(409, "the lease is not yours");
  const auto own = cell.holders().find(fence);
  if (!own || own->devices) return refuse_message(409, "a program needs the lease of all devices");
  if (const auto missing = cell.follow_log().missing(); !missing.empty())
    return refuse_message(409, fmt::format("a cell with '{}' cannot be followed", fmt::join(missing, "', '")));
  if (!cell.follow_log().begin(fence))
    return refuse_message(409, "somebody follows this cell already: wait for its end");
  fence_ = fence;
  services_.log(fmt::format("'{}' runs a program, fence {}", client_.name, fence_));
  cell.wake();
  return {};
}

MessageResult FollowSession::give(ObjectReader& message, FollowCommand command) {
  command.tag = static_cast<std::uint32_t>(message.integer("tag", {}, kTags));
  message.finish();
  if (message.diagnostics().has_errors())
    return refuse_message(422, "the message cannot be read", message.diagnostics());
  if (hosted_->follow_log().push(command)) return {};
  return refuse_message(429, "too many commands in this cycle");
}

MessageResult FollowSession::rule(ObjectReader& message) {
  return give(message, {.kind = FollowCommand::Kind::kRule, .rule = read_rule(message, services_.cell.core())});
}

MessageResult FollowSession::abort(ObjectReader& message) {
  return give(message, {.kind = FollowCommand::Kind::kAbort, .net = read_net(message, "net")});
}

MessageResult FollowSession::unload(ObjectReader& message) {
  return give(message, {.kind = FollowCommand::Kind::kUnload, .net = read_net(message, "net")});
}

device::Arm* FollowSession::read_arm(ObjectReader& message) const {
  const auto& arms = services_.cell.built().cell.arms;
  const auto found = arms.find(message.choice("arm", keys_of(arms)));
  return found == arms.end() ? nullptr : found->second.device;
}

MessageResult FollowSession::change_mode(ObjectReader& message) {
  FollowCommand command{.kind = FollowCommand::Kind::kMode, .arm = read_arm(message)};
  const std::string mode = message.text("mode");
  if (const auto known = device::control_mode_of(mode)) {
    command.mode = *known;
  } else {
    message.diagnostics().error(Code::kUnknownName, "/mode", fmt::format("there is no mode '{}'", mode),
                                "Give a mode of the arm");
  }
  return give(message, std::move(command));
}

MessageResult FollowSession::stop(ObjectReader& message) {
  const std::string text = message.text("text", "");
  message.finish();
  if (hosted_ == nullptr) {
    services_.cell.stop_all(client_.name);
    return {};
  }
  hosted_->stop_nets(net::Text(text.empty() ? fmt::format("STOP by '{}'", client_.name) : text));
  hosted_->wake();
  return {};
}

MessageResult FollowSession::write_channel(ObjectReader& message) {
  FollowCommand command{.kind = FollowCommand::Kind::kChannel};
  const auto& channels = services_.cell.built().cell.channels;
  const auto found = channels.find(message.choice("name", keys_of(channels)));
  const FollowJson* value = message.child("value");
  if (found != channels.end() && value != nullptr) {
    command.channel = found->second;
    message.diagnostics().append(read_value(*value, found->second->description().type, command.value), "/value");
  }
  return give(message, std::move(command));
}

MessageResult FollowSession::set_tool(ObjectReader& message) {
  FollowCommand command{.kind = FollowCommand::Kind::kTool, .arm = read_arm(message)};
  const std::vector<double> values = message.numbers("tool", cell::kToolValues);
  if (values.size() == cell::kToolValues) command.tool = cell::tool_of(values);
  return give(message, std::move(command));
}

MessageResult FollowSession::steps(ObjectReader& message) {
  const auto cycles = message.integer("cycles", {}, Range{.low = 1, .high = double(kMostStepsAtOnce)});
  message.finish();
  if (message.diagnostics().has_errors())
    return refuse_message(422, "the message cannot be read", message.diagnostics());
  if (services_.cell.realtime()) return refuse_message(409, "this cell runs in real time: nobody steps it");
  if (services_.cell.steps(cycles, [](const CellView&) {})) return {};
  return refuse_message(429, "too many orders wait");
}

MessageResult FollowSession::touching(ObjectReader& message) {
  const std::vector<std::string> names = message.texts("devices");
  message.finish();
  if (message.diagnostics().has_errors())
    return refuse_message(422, "the message cannot be read", message.diagnostics());
  hosted_->between_cycles([&cell = *hosted_, names](cell::CellRun&) {
    cell.set_touching({names.begin(), names.end()});
  });
  return {};
}

MessageResult FollowSession::note(ObjectReader& message) {
  const auto task = [source = message.text("source"), name = message.text("name"),
                     text = message.text("text", "")](cell::CellRun& run) { run.note(source, name, text); };
  message.finish();
  if (message.diagnostics().has_errors())
    return refuse_message(422, "the message cannot be read", message.diagnostics());
  hosted_->between_cycles(task);
  return {};
}

MessageResult FollowSession::step_begun(ObjectReader& message) {
  const auto task = [name = message.text("name")](cell::CellRun& run) { run.step_begun(name); };
  message.finish();
  if (message.diagnostics().has_errors())
    return refuse_message(422, "the message cannot be read", message.diagnostics());
  hosted_->between_cycles(task);
  return {};
}

MessageResult FollowSession::judge(ObjectReader& message) {
  message.finish();
  if (message.diagnostics().has_errors())
    return refuse_message(422, "the message cannot be read", message.diagnostics());
  hosted_->between_cycles([&cell = *hosted_, post = services_.post, socket = socket_](cell::CellRun& run) {
    const rcc::ControlCore& core = cell.core();
    const FollowJson answer = {{"op", "verdict"},
                               {"cycles", core.cycle()},
                               {"digest", to_string(cell.core().digest().value())},
                               {"expectations", results_json(run.judge_now())}};
    post([socket, text = answer.dump(-1, ' ', false, FollowJson::error_handler_t::replace)] {
      if (*socket != nullptr) (*socket)->send(WebSocket::Kind::kText, text);
    });
  });
  return {};
}

MessageResult FollowSession::leave(ObjectReader& message) {
  message.finish();
  if (message.diagnostics().has_errors())
    return refuse_message(422, "the message cannot be read", message.diagnostics());
  let_go();
  // Whoever runs the cell lets go before he does what is asked between cycles.
  hosted_->between_cycles([post = services_.post, socket = socket_](cell::CellRun&) {
    post([socket] {
      if (*socket != nullptr) (*socket)->send(WebSocket::Kind::kText, FollowJson({{"op", "left"}}).dump());
    });
  });
  return {};
}

MessageResult FollowSession::alive(ObjectReader& message) {
  message.finish();
  return {};
}

void FollowSession::say(const FollowJson& message) {
  if (*socket_ != nullptr)
    (*socket_)->send(WebSocket::Kind::kText, message.dump(-1, ' ', false, FollowJson::error_handler_t::replace));
}

void FollowSession::say_problem(const std::string& op, const MessageProblem& problem) {
  FollowJson message = {{"op", "problem"}, {"for", op}};
  message.update(problem_json(problem.status, problem.detail, problem.diagnostics));
  say(message);
}

/// Few messages are on the way at one time: whoever takes them slowly finds the rest in one.
void FollowSession::send_records() {
  while (*socket_ != nullptr && fence_ != 0 && (*socket_)->waiting() < kMostOnTheWay) {
    std::string bytes;
    while (bytes.size() < kMostBytes) {
      const auto record = hosted_->follow_log().pop();
      if (!record) break;
      const auto size = static_cast<std::uint32_t>(record->size());
      bytes.append(reinterpret_cast<const char*>(&size), sizeof(size));
      bytes += *record;
    }
    if (bytes.empty()) return;
    (*socket_)->send(WebSocket::Kind::kBinary, std::move(bytes));
  }
}

}  // namespace takt::serve
