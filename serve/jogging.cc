#include "serve/jogging.h"

#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/keys_of.h"

namespace takt::serve {
namespace {

using JogJson = nlohmann::ordered_json;

constexpr Range kTimeouts{.low = 10, .high = 1000};  ///< cycles
constexpr std::size_t kEventsAtOnce = 256;

MessageResult problem_of(int status, std::string detail, Diagnostics diagnostics = {}) {
  return std::unexpected(
      MessageProblem{.status = status, .detail = std::move(detail), .diagnostics = std::move(diagnostics)});
}

MessageResult not_holder() {
  Diagnostics why;
  why.error(Code::kNotPossibleNow, "/fence", "this is not, or no longer, the fence of the holder",
            "Take the lease with POST /v1/lease");
  return problem_of(409, "the lease is not yours", std::move(why));
}

/// The velocity is zero.
void write_zero(device::Channel& channel, int joints) {
  if (channel.description().type == net::ValueType::kTwist) {
    (void)channel.write(net::Twist{});
  } else {
    (void)channel.write(net::JointArray(Eigen::VectorXd::Zero(joints)));
  }
}

JogRequest read_jog_request(ObjectReader& message, const expression::Cell& cell) {
  JogRequest request;
  request.arm = message.text("arm");
  request.joints = message.choice("space", {"tool", "joints"}) == "joints";
  if (!request.joints) request.in = message.text("in", "world");
  request.timeout_cycles = message.integer("timeout_cycles", request.timeout_cycles, kTimeouts);
  request.linear_max =
      message.number("linear_max_m_s", request.linear_max, {.low = 0.0, .high = 1.0, .low_open = true});
  constexpr double kDegree = std::numbers::pi / 180.0;
  request.angular_max =
      message.number("angular_max_deg_s", 30.0, {.low = 0.0, .high = 180.0, .low_open = true}) * kDegree;
  if (!request.arm.empty() && !cell.arms.contains(request.arm))
    message.diagnostics().error(Code::kUnknownName, message.at("arm"),
                                fmt::format("the cell has no arm '{}'", request.arm),
                                nearest_choice(request.arm, keys_of(cell.arms)));
  return request;
}

}  // namespace

std::uint32_t read_number(ObjectReader& message, std::string_view key) {
  return static_cast<std::uint32_t>(message.integer(key, {}, Range{.low = 0, .high = 4294967295.0}));
}

Jogging::Jogging(const StreamServices& services, Client client, Send send, Fail fail)
    : services_(services), client_(std::move(client)), send_(std::move(send)), fail_(std::move(fail)) {}

MessageResult Jogging::begin(ObjectReader& message) {
  ServedCell& cell = services_.cell;
  const std::uint32_t number = read_number(message, "jog");
  Jog jog;
  jog.fence = read_number(message, "fence");
  jog.request = read_jog_request(message, cell.built().cell);
  message.finish();
  if (message.diagnostics().has_errors()) return problem_of(422, "the message cannot be read", message.diagnostics());
  if (client_.role != Role::kOperator) return problem_of(403, "observers may look and stop, and nothing else");
  if (!cell.lease().renew(jog.fence)) return not_holder();
  if (const Diagnostics why = cell.holders().check_device(jog.fence, jog.request.arm); why.has_errors())
    return problem_of(409, "you do not hold this arm", why);
  if (jogs_.contains(number)) return problem_of(409, fmt::format("jogging {} runs already", number));
  if (jogs_.size() >= kMost) return problem_of(429, fmt::format("{} joggings run: end some", kMost));
  const JogChannels channels = cell.jog_channels(jog.request.arm);
  jog.channel = jog.request.joints ? channels.joints : channels.tool;
  jog.joints = cell.built().cell.arms.at(jog.request.arm).device->joint_count();
  const auto job = [weak = weak_from_this(), &cell, request = jog.request, number, post = services_.post] {
    Result<rcc::NetId> net = std::unexpected(Diagnostics{});
    auto mapped = jog_net(cell, request);
    if (mapped) {
      net = cell.core().load(mapped->net, mapped->options);
    } else {
      net = std::unexpected(std::move(mapped.error()));
    }
    post([weak, number, net = std::move(net), &cell] {
      if (const auto self = weak.lock()) return self->made(number, net);
      if (net) (void)cell.core().unload(*net);
    });
  };
  if (!services_.work_elsewhere(job)) return problem_of(429, "too much is waiting to be done: ask again");
  jogs_.emplace(number, std::move(jog));
  return {};
}

void Jogging::made(std::uint32_t number, const Result<rcc::NetId>& net) {
  rcc::ControlCore& core = services_.cell.core();
  const auto found = jogs_.find(number);
  const auto give_up = [&](int status, const std::string& detail, const Diagnostics& why = {}) {
    if (net) (void)core.unload(*net);
    jogs_.erase(found);
    fail_("jog", number, {.status = status, .detail = detail, .diagnostics = why});
  };
  if (!net) return give_up(422, "the arm cannot be moved so", net.error());
  Jog& jog = found->second;
  if (closed_ || jog.released) {
    (void)core.unload(*net);
    send_({{"op", "jog_ended"}, {"jog", number}, {"net", *net}, {"reason", "released"}});
    jogs_.erase(found);
    return;
  }
  if (!services_.cell.lease().renew(jog.fence)) {
    const MessageProblem why = not_holder().error();
    return give_up(why.status, why.detail, why.diagnostics);
  }
  if (!services_.cell.lease().add(*net, jog.fence)) return give_up(429, "too many nets have not ended: unload some");
  if (jog.sequence < 0) write_zero(*jog.channel, jog.joints);
  jog.events_from = services_.cell.next_event();
  jog.start = core.start(*net);
  if (jog.start == 0) return give_up(429, "too many requests in this cycle: ask again");
  jog.net = *net;
  services_.log(fmt::format("'{}' moves '{}' by hand, net {}", client_.name, jog.request.arm, jog.net));
}

MessageResult Jogging::move(ObjectReader& message) {
  const std::uint32_t number = read_number(message, "jog");
  const auto sequence = message.integer("sequence", {}, kNotNegative);
  const auto found = jogs_.find(number);
  const bool joints = found != jogs_.end() && found->second.request.joints;
  net::Twist velocity;
  std::vector<double> rates;
  if (joints || message.has("rates")) {
    rates = message.numbers("rates", joints ? static_cast<std::size_t>(found->second.joints) : 0);
  } else {
    velocity.linear = message.vector("linear");
    velocity.angular = message.vector("angular", Eigen::Vector3d(Eigen::Vector3d::Zero()));
  }
  message.finish();
  if (message.diagnostics().has_errors()) return problem_of(422, "the message cannot be read", message.diagnostics());
  if (found == jogs_.end()) return problem_of(409, fmt::format("jogging {} does not run, or not any more", number));
  Jog& jog = found->second;
  if (jog.released) return problem_of(409, fmt::format("jogging {} was released", number));
  if (sequence <= jog.sequence)
    return problem_of(409, fmt::format("sequence {} comes after {}", sequence, jog.sequence));
  if (!services_.cell.lease().renew(jog.fence)) return not_holder();
  if (joints == rates.empty()) return problem_of(422, "this jogging takes the velocity of the tool");
  const auto written = joints ? jog.channel->write(net::JointArray(Eigen::Map<const Eigen::VectorXd>(
                                    rates.data(), static_cast<Eigen::Index>(rates.size()))))
                              : jog.channel->write(velocity);
  if (written != device::Channel::Written::kDone) return problem_of(503, "others write just now: send it again");
  jog.sequence = sequence;
  send_({{"op", "moved"}, {"jog", number}, {"sequence", sequence}, {"cycle", services_.cell.core().cycle()}});
  return {};
}

void Jogging::release(Jog& jog) {
  jog.released = true;
  if (jog.net == 0) return;  // made() sees it
  write_zero(*jog.channel, jog.joints);
  (void)services_.cell.core().cancel(jog.net);  // without room for it, silence ends the jogging
}

MessageResult Jogging::end(ObjectReader& message) {
  const std::uint32_t number = read_number(message, "jog");
  message.finish();
  if (message.diagnostics().has_errors()) return problem_of(422, "the message cannot be read", message.diagnostics());
  const auto found = jogs_.find(number);
  if (found == jogs_.end()) return problem_of(409, fmt::format("jogging {} does not run, or not any more", number));
  release(found->second);
  return {};
}

bool Jogging::look_for_start(std::uint32_t number, Jog& jog) {
  const auto page = services_.cell.events_from(jog.events_from, kEventsAtOnce);
  jog.events_from = page.next;
  for (const LoggedEvent& one : page.events) {
    if (one.event.request != jog.start) continue;
    if (one.event.kind == rcc::Event::Kind::kDone) {
      jog.runs = true;
      send_({{"op", "jogging"}, {"jog", number}, {"net", jog.net}, {"timeout_cycles", jog.request.timeout_cycles}});
    } else if (one.event.kind == rcc::Event::Kind::kRefused) {
      Diagnostics why;
      why.error(Code::kNotPossibleNow, "/arm", std::string(one.event.cause.text.view()),
                "Wait until the arm is free, or stop what holds it");
      fail_("jog", number, {.status = 409, .detail = "the arm cannot be moved now", .diagnostics = why});
      return false;
    }
  }
  return true;
}

std::string Jogging::why_ended(const Jog& jog) const {
  if (jog.released) return "released";
  if (!services_.cell.lease().holds(jog.fence)) return "lease";
  const net::Cause cause = services_.cell.core().status(jog.net).cause;
  return cause.code == net::Cause::Code::kTerminated ? "silent" : "stopped";
}

bool Jogging::has_ended(std::uint32_t number, const Jog& jog) const {
  rcc::ControlCore& core = services_.cell.core();
  if (core.knows(jog.net) && core.state(jog.net) != rcc::NetState::kTerminated) return false;
  send_({{"op", "jog_ended"}, {"jog", number}, {"net", jog.net}, {"reason", why_ended(jog)}});
  return true;
}

void Jogging::look() {
  for (auto one = jogs_.begin(); one != jogs_.end();) {
    auto& [number, jog] = *one;
    const bool refused = jog.net != 0 && !jog.runs && !look_for_start(number, jog);
    const bool over = refused || (jog.runs && has_ended(number, jog));
    if (over) services_.forget_later(jog.net);
    one = over ? jogs_.erase(one) : std::next(one);
  }
}

void Jogging::close() {
  closed_ = true;
  for (auto& [number, jog] : jogs_) {
    release(jog);
    if (jog.net != 0) services_.forget_later(jog.net);
  }
}

}  // namespace takt::serve
