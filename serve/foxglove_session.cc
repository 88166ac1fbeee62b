#include "serve/foxglove_session.h"

#include <algorithm>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/build/topics.h"
#include "cell/run/scene_message.h"
#include "core/base/json.h"
#include "foxglove/FrameTransforms.pb.h"
#include "foxglove/JointStates.pb.h"
#include "foxglove/Log.pb.h"
#include "record/schemas.h"
#include "serve/frames.h"

namespace takt::serve {
namespace {

using FoxJson = nlohmann::ordered_json;

constexpr std::uint8_t kMessageData = 1, kTime = 2;
constexpr std::int64_t kEveryCycles = 20;  ///< as often as in recordings
constexpr std::size_t kLinesAtOnce = 256, kDeepestMessage = 16;
constexpr int kErrorLevel = 2;

template <class Stamp>
void set_stamp(Stamp& stamp, Nanoseconds time) {
  stamp.set_seconds(time / kSecond);
  stamp.set_nanos(static_cast<int>(time % kSecond));
}

std::string base64(std::string_view bytes) {
  static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8u | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[three >> (18u - 6u * k) & 63u];
  }
  return text;
}

FoxJson channel_json(std::uint32_t id, const std::string& topic, std::string_view schema) {
  return {{"id", id},
          {"topic", topic},
          {"encoding", "protobuf"},
          {"schemaName", schema},
          {"schema", base64(record::known_schema(schema).descriptor_set)},
          {"schemaEncoding", "protobuf"}};
}

/// What happened, as a line for people.
std::string line_of(const rcc::Event& event) {
  static constexpr std::array<std::string_view, 4> kKinds = {"", "done", "refused", "stopped"};
  const std::string what = event.kind == rcc::Event::Kind::kState
                               ? std::string(name_of(event.state))
                               : std::string(kKinds[static_cast<std::size_t>(event.kind)]);
  std::string line = event.net != 0 ? fmt::format("net {}: {}", event.net, what) : what;
  if (event.request != 0) line += fmt::format(", request {}", event.request);
  if (event.cause.code != net::Cause::Code::kNone) line += fmt::format(", {}", name_of(event.cause.code));
  if (!event.cause.text.view().empty()) line += fmt::format(": {}", event.cause.text.view());
  return line;
}

/// A number of a message's array.
std::optional<std::uint32_t> number_of(const FoxJson& json) {
  if (!json.is_number_integer() || json < 0 || json > 4294967295) return {};
  return json.get<std::uint32_t>();
}

}  // namespace

FoxgloveWorld::FoxgloveWorld(const ServedCell& cell)
    : session(fmt::format("{:08x}", std::random_device()())),
      scene(cell::scene_message(*cell.built().world->model())) {}

FoxgloveSession::FoxgloveSession(const StreamServices& services, SharedSights& sights, const FoxgloveWorld& world,
                                 std::string peer, std::function<void(Stream& stream)> gone)
    : services_(services), sights_(sights), world_(world), peer_(std::move(peer)), gone_(std::move(gone)) {}

std::uint32_t FoxgloveSession::channels() const {
  return kFirstArm + static_cast<std::uint32_t>(sights_.view.arms.size());
}

void FoxgloveSession::opened(WebSocket& socket) {
  socket_ = &socket;
  say({{"op", "serverInfo"},
       {"name", "takt: " + services_.cell.description().title},
       {"capabilities", {"time"}},
       {"supportedEncodings", FoxJson::array()},
       {"metadata", FoxJson::object()},
       {"sessionId", world_.session}});
  advertise();
}

void FoxgloveSession::closed() {
  socket_ = nullptr;
  gone_(*this);
}

void FoxgloveSession::advertise() {
  FoxJson list = {channel_json(kTransforms, "/tf", record::kFrameTransformsSchema),
                  channel_json(kScene, "/scene", record::kSceneUpdateSchema),
                  channel_json(kLog, "/log", record::kLogSchema)};
  std::uint32_t id = kFirstArm;
  for (const ArmView& arm : sights_.view.arms)
    list.push_back(channel_json(id++, cell::device_topic(arm.name) + "/joint_states", record::kJointStatesSchema));
  say({{"op", "advertise"}, {"channels", std::move(list)}});
}

void FoxgloveSession::say(const FoxJson& message) {
  if (socket_ != nullptr)
    socket_->send(WebSocket::Kind::kText, message.dump(-1, ' ', false, FoxJson::error_handler_t::replace));
}

void FoxgloveSession::say_status(const std::string& text) {
  say({{"op", "status"}, {"level", kErrorLevel}, {"message", text}});
}

void FoxgloveSession::received(WebSocket::Kind kind, std::string_view text) {
  if (services_.access.too_fast(peer_)) return say_status("too many messages a second");
  if (kind != WebSocket::Kind::kText) return say_status("this server takes no data from clients");
  const auto json = parse_json(text, {.bytes = text.size(), .depth = kDeepestMessage});
  if (!json || !json->is_object()) return say_status("a message is a JSON object");
  const auto op = json->find("op");
  if (op == json->end() || !op->is_string()) return say_status("a message has an op");
  if (*op == "subscribe") return subscribe(*json);
  if (*op == "unsubscribe") return unsubscribe(*json);
  say_status(fmt::format("'{}' is not possible here", op->get<std::string>()));
}

void FoxgloveSession::subscribe(const FoxJson& message) {
  const auto list = message.find("subscriptions");
  if (list == message.end() || !list->is_array()) return say_status("subscribe: no subscriptions");
  for (const FoxJson& one : *list) {
    const auto id = one.is_object() && one.contains("id") ? number_of(one["id"]) : std::nullopt;
    const auto channel = one.is_object() && one.contains("channelId") ? number_of(one["channelId"]) : std::nullopt;
    if (!id || !channel || *channel == 0 || *channel >= channels()) {
      say_status("subscribe: there is no such channel");
      continue;
    }
    const bool used = std::ranges::any_of(subscriptions_, [&id](const auto& known) { return known.second == *id; });
    if (used || !subscriptions_.emplace(*channel, *id).second) {
      say_status(fmt::format("subscribe: channel {} or number {} is in use", *channel, *id));
      continue;
    }
    if (*channel == kScene) send_data(kScene, sights_.view.time, world_.scene);
    if (*channel == kLog) next_event_ = services_.cell.next_event();
  }
  last_ = -1;
  look();
}

void FoxgloveSession::unsubscribe(const FoxJson& message) {
  const auto list = message.find("subscriptionIds");
  if (list == message.end() || !list->is_array()) return say_status("unsubscribe: no subscriptionIds");
  for (const FoxJson& one : *list) {
    const auto id = number_of(one);
    const auto gone = std::erase_if(subscriptions_, [&id](const auto& known) { return id && known.second == *id; });
    if (gone == 0) say_status("unsubscribe: there is no such subscription");
  }
}

void FoxgloveSession::drained() {
  send_log();
  send_values();
}

void FoxgloveSession::look() { drained(); }

void FoxgloveSession::send_data(std::uint32_t channel, Nanoseconds time, std::string_view data) {
  const auto found = subscriptions_.find(channel);
  if (socket_ == nullptr || found == subscriptions_.end()) return;
  std::string bytes;
  append_number(bytes, kMessageData);
  append_number(bytes, found->second);
  append_number(bytes, static_cast<std::uint64_t>(time));
  bytes += data;
  socket_->send(WebSocket::Kind::kBinary, std::move(bytes));
}

void FoxgloveSession::send_time(Nanoseconds time) {
  std::string bytes;
  append_number(bytes, kTime);
  append_number(bytes, static_cast<std::uint64_t>(time));
  socket_->send(WebSocket::Kind::kBinary, std::move(bytes));
}

void FoxgloveSession::send_log() {
  if (!subscriptions_.contains(kLog) || socket_ == nullptr || socket_->waiting() > 0) return;
  const auto page = services_.cell.events_from(next_event_, kLinesAtOnce);
  if (page.lost) say_status("lines of the log are lost: this client was too slow for them");
  next_event_ = page.next;
  for (const LoggedEvent& one : page.events) {
    foxglove::Log log;
    const Nanoseconds time = one.cycle * services_.cell.period();
    set_stamp(*log.mutable_timestamp(), time);
    const bool bad = one.event.kind == rcc::Event::Kind::kStopped || one.event.kind == rcc::Event::Kind::kRefused;
    log.set_level(bad ? foxglove::Log::WARNING : foxglove::Log::INFO);
    log.set_name("core");
    log.set_message(line_of(one.event));
    send_data(kLog, time, log.SerializeAsString());
  }
}

void FoxgloveSession::send_values() {
  const std::int64_t now = sights_.view.cycle - 1;
  const bool due = now >= 0 && (last_ < 0 || now / kEveryCycles > last_ / kEveryCycles);
  if (!due || subscriptions_.empty() || socket_ == nullptr || socket_->waiting() > 0) return;
  last_ = now;
  const Nanoseconds time = now * services_.cell.period();
  send_time(time);
  if (subscriptions_.contains(kTransforms)) send_data(kTransforms, time, transforms(time));
  for (std::size_t arm = 0; arm < sights_.view.arms.size(); ++arm) {
    const auto channel = kFirstArm + static_cast<std::uint32_t>(arm);
    if (subscriptions_.contains(channel)) send_data(channel, time, joint_states(arm, time));
  }
}

std::string FoxgloveSession::transforms(Nanoseconds time) {
  foxglove::FrameTransforms message;
  const auto& bodies = sights_.scene.bodies();
  const auto& poses = sights_.scene.place(sights_.view.picture.positions, {});
  const auto& moving = sights_.scene.moving();
  std::vector<Eigen::Isometry3d> all;
  for (const cell::SceneBody& body : bodies) all.push_back(body.X_WB);
  for (std::size_t i = 0; i < moving.size(); ++i) all[static_cast<std::size_t>(moving[i])] = poses[i];
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    foxglove::FrameTransform& transform = *message.add_transforms();
    set_stamp(*transform.mutable_timestamp(), time);
    transform.set_parent_frame_id("world");
    transform.set_child_frame_id(bodies[i].name);
    const auto& p = all[i].translation();
    transform.mutable_translation()->set_x(p.x());
    transform.mutable_translation()->set_y(p.y());
    transform.mutable_translation()->set_z(p.z());
    const Eigen::Quaterniond q(all[i].linear());
    transform.mutable_rotation()->set_w(q.w());
    transform.mutable_rotation()->set_x(q.x());
    transform.mutable_rotation()->set_y(q.y());
    transform.mutable_rotation()->set_z(q.z());
  }
  return message.SerializeAsString();
}

std::string FoxgloveSession::joint_states(std::size_t arm, Nanoseconds time) const {
  const ArmView& view = sights_.view.arms[arm];
  const auto& names = services_.cell.built().cell.arms.at(view.name).device->description().joint_names;
  foxglove::JointStates message;
  set_stamp(*message.mutable_timestamp(), time);
  for (Eigen::Index i = 0; i < view.q_measured.size(); ++i) {
    foxglove::JointState& joint = *message.add_joints();
    joint.set_name(names[static_cast<std::size_t>(i)]);
    joint.set_position(view.q_measured[i]);
    if (i < view.dq_measured.size()) joint.set_velocity(view.dq_measured[i]);
    if (i < view.tau_measured.size()) joint.set_effort(view.tau_measured[i]);
  }
  return message.SerializeAsString();
}

}  // namespace takt::serve
