#include "serve/stream_session.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/keys_of.h"
#include "serve/cell_json.h"

namespace takt::serve {
namespace {

using StreamJson = nlohmann::ordered_json;

constexpr std::size_t kEventsInOne = 256, kDeepest = 16;
constexpr unsigned short kNotText = 1003, kNotJson = 1007, kNoObject = 1008, kEventsLost = 4008;
constexpr double kMostWindow = 64;
constexpr std::array<std::string_view, 4> kArmValues = {"q_measured", "q_commanded", "dq_measured", "tau_measured"};
constexpr std::array<device::JointVector ArmView::*, 4> kArmMembers = {&ArmView::q_measured, &ArmView::q_commanded,
                                                                       &ArmView::dq_measured, &ArmView::tau_measured};
constexpr Range kNumbers{.low = 0, .high = 4294967295.0};

MessageProblem bad_message(const Diagnostics& diagnostics) {
  return {.status = 422, .detail = "the message cannot be read", .diagnostics = diagnostics};
}
std::unexpected<MessageProblem> refused_message(int status, std::string detail, Diagnostics diagnostics = {}) {
  return std::unexpected(
      MessageProblem{.status = status, .detail = std::move(detail), .diagnostics = std::move(diagnostics)});
}

std::optional<device::ChannelValue> joints_value(const device::JointVector& joints) {
  if (joints.size() == 0) return {};
  return device::ChannelValue(net::JointArray(joints));
}

std::optional<device::ChannelValue> wrench_value(const std::optional<net::Wrench>& wrench) {
  if (!wrench) return {};
  return device::ChannelValue(*wrench);
}

}  // namespace

StreamSession::StreamSession(const StreamServices& services, SharedSights& sights, Client client, std::string peer,
                             std::function<void(Stream& stream)> gone)
    : services_(services),
      sights_(sights),
      client_(std::move(client)),
      peer_(std::move(peer)),
      gone_(std::move(gone)),
      jogging_(std::make_shared<Jogging>(
          services_, client_, [this](const StreamJson& message) { say(message); },
          [this](const std::string& op, std::uint32_t jog, const MessageProblem& problem) {
            say_problem(op, jog, problem);
          })) {}

void StreamSession::opened(WebSocket& socket) {
  socket_ = &socket;
  say({{"op", "hello"},
       {"protocol", kProtocol},
       {"name", client_.name},
       {"role", name_of(client_.role)},
       {"realtime", services_.cell.realtime()},
       {"period_s", to_seconds(services_.cell.period())},
       {"cycle", services_.cell.core().cycle()},
       {"next", services_.cell.next_event()}});
}

void StreamSession::closed() {
  socket_ = nullptr;
  jogging_->close();
  for (auto& [id, monitor] : monitors_)
    if (monitor.watch != nullptr) monitor.watch->leave(&monitor);
  monitors_.clear();
  gone_(*this);
}

void StreamSession::received(WebSocket::Kind kind, std::string_view text) {
  if (kind != WebSocket::Kind::kText) return socket_->close(kNotText, "messages of clients are texts");
  const auto json = parse_json(text, {.bytes = text.size(), .depth = kDeepest});
  if (!json) return socket_->close(kNotJson, "a message is a JSON object");
  if (!json->is_object()) return socket_->close(kNoObject, "a message is a JSON object");
  Diagnostics diagnostics;
  ObjectReader message(*json, "", diagnostics);
  const std::string op = message.text("op");
  const StreamJson id = json->contains("id") ? json->at("id") : json->contains("jog") ? json->at("jog") : StreamJson();
  if (services_.access.too_fast(peer_))
    return say_problem(
        op, id,
        {.status = 429, .detail = fmt::format("more than {:g} a second", services_.access.requests_per_second())});
  std::vector<std::string> names;
  for (const ClientMessage& known : client_messages()) {
    names.push_back(known.form.op);
    if (known.form.op != op) continue;
    if (const auto done = (this->*known.handle)(message); !done) say_problem(op, id, done.error());
    return;
  }
  if (!diagnostics.has_errors())
    diagnostics.error(Code::kUnknownName, "/op", fmt::format("unknown message '{}'", op), nearest_choice(op, names));
  say_problem(op, id, bad_message(diagnostics));
}

void StreamSession::drained() {
  send_events();
  send_frames();
}

void StreamSession::look() {
  jogging_->look();
  send_events();
  send_frames();
}

void StreamSession::say(const StreamJson& message) {
  if (socket_ != nullptr)
    socket_->send(WebSocket::Kind::kText, message.dump(-1, ' ', false, StreamJson::error_handler_t::replace));
}

void StreamSession::say_problem(const std::string& op, const StreamJson& id, const MessageProblem& problem) {
  StreamJson message = {{"op", "problem"}, {"for", op}};
  if (id.is_number_integer()) message["id"] = id;
  message.update(problem_json(problem.status, problem.detail, problem.diagnostics));
  say(message);
}

void StreamSession::say_monitored(std::uint32_t id, const Monitor& monitor) {
  const std::string_view type = monitor.poses              ? "Poses"
                                : monitor.feed != nullptr  ? "Picture"
                                : monitor.watch != nullptr ? net::name_of(monitor.watch->type())
                                : monitor.sensor           ? net::name_of(net::ValueType::kWrench)
                                                           : net::name_of(net::ValueType::kJoints);
  say({{"op", "monitored"}, {"id", id}, {"type", type}, {"every", monitor.every}});
}

MessageResult StreamSession::begin_events(ObjectReader& message) {
  const auto from = message.integer("from", services_.cell.next_event(), Range{.low = 1, .high = 9e15});
  message.finish();
  if (message.diagnostics().has_errors()) return std::unexpected(bad_message(message.diagnostics()));
  next_event_ = from;
  send_events();
  return {};
}

/// The log keeps them: a client that is slow gets them later, one that is too slow is told where it can go on.
void StreamSession::send_events() {
  if (socket_ == nullptr || next_event_ == 0 || socket_->waiting() > 0) return;
  const auto page = services_.cell.events_from(next_event_, kEventsInOne);
  if (page.lost) {
    const std::int64_t oldest = page.next - static_cast<std::int64_t>(page.events.size());
    return socket_->close(kEventsLost, fmt::format("resume {}", oldest));
  }
  next_event_ = page.next;
  if (page.events.empty()) return;
  StreamJson list = StreamJson::array();
  for (const LoggedEvent& event : page.events) list.push_back(to_json(event));
  say({{"op", "events"}, {"events", std::move(list)}, {"next", page.next}});
}

void StreamSession::read_arm_monitor(ObjectReader& message, Monitor& monitor) const {
  const std::string arm = message.text("arm");
  const std::string value = message.choice("value", {kArmValues.begin(), kArmValues.end()});
  const auto& arms = sights_.view.arms;
  const auto found = std::ranges::find(arms, arm, &ArmView::name);
  if (found == arms.end()) {
    std::vector<std::string> names;
    for (const ArmView& one : arms) names.push_back(one.name);
    message.diagnostics().error(Code::kUnknownName, message.at("arm"), fmt::format("the cell has no arm '{}'", arm),
                                nearest_choice(arm, names));
    return;
  }
  monitor.arm = static_cast<std::size_t>(found - arms.begin());
  const auto member = std::ranges::find(kArmValues, value);
  if (member != kArmValues.end()) monitor.value = kArmMembers[static_cast<std::size_t>(member - kArmValues.begin())];
}

void StreamSession::read_sensor_monitor(ObjectReader& message, Monitor& monitor) const {
  const std::string sensor = message.text("sensor");
  const auto& sensors = sights_.view.sensors;
  const auto found = std::ranges::find(sensors, sensor, &SensorView::name);
  if (found != sensors.end()) {
    monitor.sensor = static_cast<std::size_t>(found - sensors.begin());
    return;
  }
  std::vector<std::string> names;
  for (const SensorView& one : sensors) names.push_back(one.name);
  message.diagnostics().error(Code::kUnknownName, message.at("sensor"),
                              fmt::format("the cell has no force/torque sensor '{}'", sensor),
                              nearest_choice(sensor, names));
}

void StreamSession::read_camera_monitor(ObjectReader& message, Monitor& monitor) const {
  using Camera = cell::CellCamera;
  monitor.format.camera = message.text("camera");
  monitor.format.width =
      static_cast<int>(message.integer("width", 320, Range{.low = Camera::kLeast, .high = Camera::kMostWidth}));
  monitor.format.height =
      static_cast<int>(message.integer("height", 240, Range{.low = Camera::kLeast, .high = Camera::kMostHeight}));
  message.diagnostics().append(check_camera(sights_.scene, monitor.format.camera, message.at("camera")));
}

std::expected<StreamSession::Monitor, MessageProblem> StreamSession::read_monitor(ObjectReader& message) const {
  Monitor monitor;
  Diagnostics& diagnostics = message.diagnostics();
  rcc::NetId net = 0;
  std::string port;
  const int kinds = static_cast<int>(message.has("net")) + static_cast<int>(message.has("channel")) +
                    static_cast<int>(message.has("arm")) + static_cast<int>(message.has("sensor")) +
                    static_cast<int>(message.has("camera")) + static_cast<int>(message.has("poses"));
  if (kinds != 1)
    diagnostics.error(Code::kRequires, message.pointer(), "it is not clear what is to be watched",
                      "Give one of: net and port, channel, arm and value, sensor, camera, poses");
  if (message.has("net")) {
    net = static_cast<rcc::NetId>(message.integer("net", {}, Range{.low = 1, .high = kNumbers.high}));
    port = message.text("port");
  } else if (message.has("channel")) {
    port = message.text("channel");
  } else if (message.has("arm")) {
    read_arm_monitor(message, monitor);
  } else if (message.has("sensor")) {
    read_sensor_monitor(message, monitor);
  } else if (message.has("camera")) {
    read_camera_monitor(message, monitor);
  } else if (message.has("poses") && !message.boolean("poses")) {
    diagnostics.error(Code::kInvalidValue, message.at("poses"), "false", "Write true, or leave it out");
  }
  monitor.poses = message.has("poses");
  monitor.every = static_cast<int>(message.integer("every", 1, Range{.low = 0, .high = kMostEvery}));
  message.finish();
  if (diagnostics.has_errors()) return std::unexpected(bad_message(diagnostics));
  if (!monitor.format.camera.empty()) monitor.feed = services_.pictures.feed(monitor.format);
  if (port.empty()) return monitor;
  auto watch = sights_.watches.open(net, port);
  if (!watch) {
    const bool full = watch.error().list().front().code == Code::kNotPossibleNow;
    return refused_message(full ? 429 : 422, "this cannot be watched", watch.error());
  }
  monitor.watch = std::move(*watch);
  return monitor;
}

MessageResult StreamSession::add_monitor(ObjectReader& message) {
  const std::uint32_t id = read_number(message, "id");
  if (monitors_.size() >= kMostMonitors)
    return refused_message(429, fmt::format("there are {} monitors: end some", kMostMonitors));
  if (monitors_.contains(id)) return refused_message(409, fmt::format("there is a monitor {} already", id));
  auto monitor = read_monitor(message);
  if (!monitor) return std::unexpected(std::move(monitor.error()));
  Monitor& added = monitors_.emplace(id, std::move(*monitor)).first->second;
  if (added.watch != nullptr) added.watch->set_every(&added, added.every);
  say_monitored(id, added);
  send_frames();
  return {};
}

MessageResult StreamSession::set_rate(ObjectReader& message) {
  const std::uint32_t id = read_number(message, "id");
  const auto every = message.integer("every", {}, Range{.low = 0, .high = kMostEvery});
  message.finish();
  if (message.diagnostics().has_errors()) return std::unexpected(bad_message(message.diagnostics()));
  const auto found = monitors_.find(id);
  if (found == monitors_.end()) return refused_message(404, fmt::format("there is no monitor {}", id));
  Monitor& monitor = found->second;
  monitor.every = static_cast<int>(every);
  if (monitor.watch != nullptr) monitor.watch->set_every(&monitor, monitor.every);
  say_monitored(id, monitor);
  return {};
}

MessageResult StreamSession::end_monitor(ObjectReader& message) {
  const std::uint32_t id = read_number(message, "id");
  message.finish();
  if (message.diagnostics().has_errors()) return std::unexpected(bad_message(message.diagnostics()));
  const auto found = monitors_.find(id);
  if (found == monitors_.end()) return refused_message(404, fmt::format("there is no monitor {}", id));
  if (found->second.watch != nullptr) found->second.watch->leave(&found->second);
  monitors_.erase(found);
  say({{"op", "ended"}, {"id", id}, {"reason", "asked"}});
  return {};
}

MessageResult StreamSession::acknowledge(ObjectReader& message) {
  const std::uint32_t frame = read_number(message, "frame");
  message.finish();
  if (message.diagnostics().has_errors()) return std::unexpected(bad_message(message.diagnostics()));
  if (frame > last_frame_) return refused_message(409, fmt::format("frame {} has not been sent", frame));
  acknowledged_ = std::max(acknowledged_, frame);
  send_frames();
  return {};
}

MessageResult StreamSession::set_window(ObjectReader& message) {
  const auto frames = message.integer("frames", {}, Range{.low = 1, .high = kMostWindow});
  message.finish();
  if (message.diagnostics().has_errors()) return std::unexpected(bad_message(message.diagnostics()));
  window_ = static_cast<std::uint32_t>(frames);
  send_frames();
  return {};
}

bool StreamSession::has_room() const {
  return socket_ != nullptr && last_frame_ - acknowledged_ < window_ && socket_->waiting() < kMostWindow;
}

bool StreamSession::is_due(const Monitor& monitor, std::int64_t cycle) const {
  return monitor.every > 0 && cycle >= 0 && (monitor.last < 0 || cycle / monitor.every > monitor.last / monitor.every);
}

bool StreamSession::poses_are_due() const {
  return std::ranges::any_of(
      monitors_, [this](const auto& one) { return one.second.poses && is_due(one.second, sights_.view.cycle - 1); });
}

void StreamSession::send_frames() {
  if (monitors_.empty() || socket_ == nullptr) return;
  if (has_room() && std::exchange(poses_next_, false)) send_poses();
  if (has_room()) send_values();
  if (has_room()) {
    send_poses();
  } else {
    poses_next_ = poses_are_due();
  }
  send_pictures();
  end_monitors_of_ended_nets();
}

/// A picture is asked for when it is due and the client is ready for one, and sent once it is there: whoever is slow
/// gets fewer, and the maker never draws what nobody takes.
void StreamSession::send_pictures() {
  const std::int64_t now = sights_.view.cycle - 1;
  for (auto& [id, monitor] : monitors_) {
    if (monitor.feed == nullptr || !has_room()) continue;
    const auto newest = monitor.feed->newest();
    if (newest != nullptr && newest->cycle - 1 > monitor.last && newest->cycle - 1 >= monitor.asked) {
      monitor.last = newest->cycle - 1;
      socket_->send(WebSocket::Kind::kBinary, picture_frame(++last_frame_, id, monitor.format, *newest));
    }
    const bool answered = monitor.last >= monitor.asked;
    if (!answered || monitor.every == 0 || now < 0) continue;
    if (monitor.asked >= 0 && now / monitor.every <= monitor.asked / monitor.every) continue;
    monitor.asked = now;
    monitor.feed->want();
  }
}

void StreamSession::send_values() {
  const std::int64_t now = sights_.view.cycle - 1;
  ValueFrame frame;
  for (auto& [id, monitor] : monitors_) {
    if (monitor.watch != nullptr) {
      const auto newest = monitor.watch->newest();
      if (!newest || !is_due(monitor, newest->cycle)) continue;
      frame.add(id, monitor.watch->type(), newest->cycle, newest->value);
      monitor.last = newest->cycle;
    } else if (monitor.value != nullptr && is_due(monitor, now)) {
      frame.add(id, net::ValueType::kJoints, now, joints_value(sights_.view.arms[monitor.arm].*monitor.value));
      monitor.last = now;
    } else if (monitor.sensor && is_due(monitor, now)) {
      frame.add(id, net::ValueType::kWrench, now, wrench_value(sights_.view.sensors[*monitor.sensor].wrench));
      monitor.last = now;
    }
  }
  if (!frame.empty()) socket_->send(WebSocket::Kind::kBinary, frame.finish(++last_frame_, now));
}

void StreamSession::send_poses() {
  if (!poses_are_due()) return;
  const CellView& view = sights_.view;
  std::vector<cell::CommandedJoints> commanded;
  for (const ArmView& arm : view.arms)
    commanded.push_back({arm.name, {arm.q_commanded.data(), static_cast<std::size_t>(arm.q_commanded.size())}});
  const auto& poses = sights_.scene.place(view.picture.positions, commanded);
  const std::span all(poses);
  const std::size_t moving = sights_.scene.moving().size();
  const std::int64_t now = view.cycle - 1;
  socket_->send(WebSocket::Kind::kBinary,
                pose_frame(++last_frame_, now, now * services_.cell.period(), all.first(moving), all.subspan(moving)));
  for (auto& [id, monitor] : monitors_)
    if (monitor.poses) monitor.last = now;
}

/// Their last values have been sent, or were replaced by none.
void StreamSession::end_monitors_of_ended_nets() {
  for (auto one = monitors_.begin(); one != monitors_.end();) {
    auto& [id, monitor] = *one;
    const bool ended = monitor.watch != nullptr && monitor.watch->ended();
    const auto newest = ended ? monitor.watch->newest() : std::nullopt;
    if (!ended || (newest && is_due(monitor, newest->cycle))) {
      ++one;
      continue;
    }
    monitor.watch->leave(&monitor);
    say({{"op", "ended"}, {"id", id}, {"reason", "net"}});
    one = monitors_.erase(one);
  }
}

}  // namespace takt::serve
