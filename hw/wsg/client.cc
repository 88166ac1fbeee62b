#include "hw/wsg/client.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace takt::hw::wsg {
namespace {

using device::GripperState;

constexpr Nanoseconds kRetry = 500 * kMillisecond;    // between two attempts to connect
constexpr Nanoseconds kAnswerTimeout = kSecond;       // for an answer of the set-up
constexpr Nanoseconds kHomingTime = 60 * kSecond;     // the slowest speed over the longest stroke takes half of it
constexpr Nanoseconds kSilence = 200 * kMillisecond;  // and ten updates: the connection is taken to be broken
constexpr double kAtWidth = 3e-4;                     // m: nearer than this the fingers are where they are wanted
constexpr double kPartLostDistance = 1.5e-3;          // m: farther than pads give way, what was met is gone
constexpr double kSameStroke = 1e-3;                  // m: strokes that differ by more are of different grippers
constexpr std::size_t kMostNews = 64;

/// What comes by itself; the width last, as it completes a sample.
constexpr Command kUpdates[] = {Command::kSystemState, Command::kGraspState, Command::kSpeed, Command::kForce,
                                Command::kWidth};

}  // namespace

Client::Client(const ClientOptions& options, const device::GripperRequest& request, Network& network,
               const Clock& clock)
    : options_(options), description_(request.description), network_(network), clock_(clock) {}

bool Client::read(device::GripperSample& sample) {
  (void)samples_.take();
  sample = samples_.value();
  return sample.sequence > 0;
}

void Client::write(const device::GripperSetPoint& set_point) { commands_.publish(set_point); }

std::string Client::fault_text(std::uint32_t fault) {
  switch (static_cast<Fault>(fault)) {
    case Fault::kNone:
      return {};
    case Fault::kLost:
      return "the connection to the gripper is lost; check its cable and its power";
    case Fault::kNotConnected:
      return "the gripper does not answer; check its address, its cable, and that its command interface is TCP";
    case Fault::kStarting:
      return "the connection is being set up";
    case Fault::kWrongGripper:
      return "the gripper's limits are not those of the model";
    case Fault::kNotReferenced:
      return "the fingers are not referenced; home them at the gripper, or set home=true";
    case Fault::kFastStop:
      return "FAST STOP; acknowledge it";
    case Fault::kHardware:
      return "the gripper reports a fault of its power, current, temperature or a finger";
    case Fault::kRefused:
      return "the gripper refused a command; acknowledge it";
  }
  return {};
}

void Client::tell(std::string line) {
  const std::scoped_lock lock(news_mutex_);
  if (news_.size() < kMostNews) news_.push_back(std::move(line));
}

void Client::keep_refusal(std::string why) {
  if (!why.empty()) tell(why);
  const std::scoped_lock lock(news_mutex_);
  refusal_ = std::move(why);
}

std::string Client::refusal() const {
  const std::scoped_lock lock(news_mutex_);
  return refusal_;
}

std::vector<std::string> Client::news() {
  const std::scoped_lock lock(news_mutex_);
  return std::exchange(news_, {});
}

// -- The connection --------------------------------------------------------------------------------------------------

void Client::connect(Nanoseconds now) {
  if (now < next_try_) return;
  next_try_ = now + kRetry;
  parser_.reset();
  (void)link_.connect(network_, options_.remote);
}

void Client::lose(Nanoseconds now, const std::string& why) {
  if (step_ != Step::kIdle) tell("connection lost: " + why);
  link_.close();
  step_ = Step::kIdle;
  interrupted_ = interrupted_ || motion_ || stopping_ || wanted_.sequence != current_.sequence;
  if (interrupted_) answered_ = 0;
  motion_.reset();
  setting_.reset();
  limit_.reset();
  stopping_ = blocked_ = part_lost_ = false;
  settled_ = true;
  if (sample_.sequence > 0) publish(now);
}

void Client::service_connection(Nanoseconds now) {
  switch (link_.state()) {
    case ByteLink::State::kConnecting:
      if (now - next_try_ > kRetry) link_.close();
      return;
    case ByteLink::State::kOpen:
      break;
    case ByteLink::State::kEnded:
    case ByteLink::State::kFailed:
      if (step_ != Step::kIdle) lose(now, link_.state() == ByteLink::State::kEnded ? "closed by it" : link_.error());
      return connect(now);
  }
  if (step_ == Step::kIdle) {
    ++counts_.connections;
    heard_at_ = now;
    refused_ = wrong_ = false;
    keep_refusal({});
    go_on(Step::kLimits, now);
  }
}

/// After what has come was taken: a process that slept for a while finds it all at once.
void Client::watch_silence(Nanoseconds now) {
  const Nanoseconds patience = step_ == Step::kHome ? kHomingTime : kAnswerTimeout;
  if (step_ == Step::kRunning && now - heard_at_ > std::max(kSilence, 10 * options_.update))
    return lose(now, "silence");
  if (step_ > Step::kIdle && step_ < Step::kRunning && now - asked_at_ > patience) lose(now, "no answer");
}

void Client::ask(Command command, std::string_view payload, Nanoseconds now) {
  std::string packet;
  append_packet(packet, static_cast<std::uint8_t>(command), payload);
  link_.send(packet);
  asked_at_ = now;
  awaited_ = command;
}

void Client::go_on(Step step, Nanoseconds now) {
  step_ = step;
  switch (step) {
    case Step::kLimits:
      return ask(Command::kLimits, {}, now);
    case Step::kAcknowledge:
      return ask(Command::kAcknowledge, "ack", now);
    case Step::kState:
      return ask(Command::kSystemState, auto_update_payload({}), now);
    case Step::kHome:
      return ask(Command::kHome, std::string_view("\0", 1), now);
    case Step::kAcceleration:
      return ask(Command::kSetAcceleration, number_payload(Command::kSetAcceleration, description_->acceleration), now);
    case Step::kUpdates:
      updates_asked_ = 0;
      for (const Command update : kUpdates)
        ask(update, auto_update_payload({true, false, static_cast<std::uint16_t>(options_.update / kMillisecond)}),
            now);
      return;
    case Step::kIdle:
    case Step::kRunning:
    case Step::kFailed:
      return;
  }
}

void Client::poll() {
  const Nanoseconds now = clock_.now();
  service_connection(now);
  link_.receive([this](std::string_view bytes) { parser_.feed(bytes); });
  while (step_ != Step::kIdle) {
    const auto packet = parser_.next();
    if (!packet) break;
    handle(*packet, now);
  }
  watch_silence(now);
  if (commands_.take()) wanted_ = commands_.value();
  acknowledge_on_reset(now);
  if (step_ == Step::kRunning) follow(now);
  link_.flush();
}

void Client::leave() {
  if (!link_.open()) return;
  ask(Command::kDisconnect, {}, clock_.now());
  link_.flush();
}

// -- What comes ------------------------------------------------------------------------------------------------------

void Client::handle(const Packet& packet, Nanoseconds now) {
  const auto answer = parse_answer(packet.payload);
  if (!packet.intact || !answer) {
    ++counts_.damaged;
    return;
  }
  const auto command = static_cast<Command>(packet.command);
  heard_at_ = now;
  if (step_ < Step::kRunning && handle_set_up(command, *answer, now)) return;
  if (answer->status == Status::kSuccess && std::ranges::find(kUpdates, command) != std::end(kUpdates))
    return handle_update(command, *answer, now);
  if (step_ != Step::kRunning) return;
  if (command == motion_) return handle_motion(*answer);
  if (answer->status == Status::kPending) return;
  if (command == Command::kStop) {
    stopping_ = false;
    // Its answer may come before that of the motion that it stops, or alone.
    motion_.reset();
    settled_ = false;
  } else if (command == Command::kSetForce && setting_) {
    if (answer->status != Status::kSuccess) return refuse(command, answer->status);
    limit_ = std::exchange(setting_, std::nullopt);
  } else if (command == Command::kAcknowledge) {
    flags_ &= ~kFastStopped;
  }
}

/// @return it was what the set-up waited for
bool Client::handle_set_up(Command command, const Answer& answer, Nanoseconds now) {
  if (command != awaited_ && step_ != Step::kUpdates) return false;
  if (answer.status == Status::kPending) return true;
  const bool done = answer.status == Status::kSuccess;
  if (!done && step_ != Step::kHome && step_ != Step::kAcknowledge) {
    keep_refusal(fmt::format("the set-up was refused: command {:02X}h, {}", static_cast<unsigned>(command),
                             name_of(answer.status)));
    refused_ = true;
    step_ = Step::kFailed;
    publish(now);
    return true;
  }
  switch (step_) {
    case Step::kLimits:
      handle_limits(answer, now);
      break;
    case Step::kAcknowledge:
      go_on(Step::kState, now);
      break;
    case Step::kState:
      handle_update(command, answer, now);
      go_on((flags_ & kReferenced) == 0 && options_.home ? Step::kHome : Step::kAcceleration, now);
      break;
    case Step::kHome:
      if (!done) tell(fmt::format("homing failed: {}", name_of(answer.status)));
      go_on(Step::kAcceleration, now);
      break;
    case Step::kAcceleration:
      go_on(Step::kUpdates, now);
      break;
    case Step::kUpdates:
      if (std::ranges::find(kUpdates, command) == std::end(kUpdates)) return false;
      handle_update(command, answer, now);
      if (++updates_asked_ < std::size(kUpdates)) break;
      step_ = Step::kRunning;
      ran_ = true;
      // What was wanted before it is connected again is over: nothing moves by an old command.
      if (counts_.connections > 1) current_ = wanted_;
      interrupted_ = false;
      tell(fault() == Fault::kNone ? "connected, ready"
                                   : "connected: " + fault_text(static_cast<std::uint32_t>(fault())));
      break;
    default:
      break;
  }
  return true;
}

void Client::handle_limits(const Answer& answer, Nanoseconds now) {
  const auto limits = parse_limits(answer.parameters);
  const bool same = limits && std::abs(limits->stroke - description_->stroke) < kSameStroke &&
                    limits->force_min <= description_->force_min + 1e-3 &&
                    limits->force_nominal >= description_->force_max - 1e-3;
  if (same) return go_on(counts_.connections == 1 ? Step::kAcknowledge : Step::kState, now);
  wrong_ = true;
  step_ = Step::kFailed;
  keep_refusal(
      limits
          ? fmt::format("another gripper: stroke {:.1f} mm and {:.0f} to {:.0f} N, the model has {:.1f} mm and {:.0f} "
                        "to {:.0f} N; use its model",
                        1e3 * limits->stroke, limits->force_min, limits->force_nominal, 1e3 * description_->stroke,
                        description_->force_min, description_->force_max)
          : "its limits cannot be read: is there a gripper of the WSG series?");
  publish(now);
}

void Client::handle_update(Command command, const Answer& answer, Nanoseconds now) {
  PayloadReader reader(answer.parameters);
  const auto take_number = [&](double& value) {
    const auto number = parse_number(command, answer.parameters);
    if (!number || !std::isfinite(*number)) {
      ++counts_.damaged;
      return false;
    }
    value = *number;
    return true;
  };
  switch (command) {
    case Command::kSystemState: {
      const auto flags = reader.take<std::uint32_t>();
      if (reader.whole()) flags_ = flags;
      break;
    }
    case Command::kGraspState: {
      const auto grasp = reader.take<std::uint8_t>();
      if (!reader.whole()) break;
      grasp_ = static_cast<GraspState>(grasp);
      if (!motion_ && !stopping_) settled_ = true;
      break;
    }
    case Command::kSpeed:
      (void)take_number(speed_);
      break;
    case Command::kForce:
      (void)take_number(force_);
      break;
    case Command::kWidth:
      if (take_number(width_)) publish(now);
      break;
    default:
      break;
  }
}

void Client::refuse(Command command, Status status) {
  keep_refusal(fmt::format("command {:02X}h refused: {}", static_cast<unsigned>(command), name_of(status)));
  motion_.reset();
  setting_.reset();
  refused_ = true;
  answered_ = 0;
}

void Client::handle_motion(const Answer& answer) {
  answered_ = current_.sequence;
  if (answer.status == Status::kPending) return;
  const Command command = *std::exchange(motion_, std::nullopt);
  settled_ = false;
  switch (answer.status) {
    case Status::kSuccess:
    case Status::kAborted:
    case Status::kFailed:  // of a grasp: there was no part
      return;
    case Status::kAxisBlocked:
      blocked_ = true;
      return;
    default:
      return refuse(command, answer.status);
  }
}

// -- What is commanded -----------------------------------------------------------------------------------------------

bool Client::holds() const { return blocked_ ? !part_lost_ : grasp_ == GraspState::kHolding; }

void Client::follow(Nanoseconds now) {
  if (wanted_.sequence == current_.sequence || stopping_ || setting_ || fault() != Fault::kNone) return;
  if (motion_) {
    stopping_ = true;
    return ask(Command::kStop, {}, now);
  }
  if (limit_ != wanted_.force) {
    setting_ = wanted_.force;
    return ask(Command::kSetForce, number_payload(Command::kSetForce, wanted_.force), now);
  }
  if (settled_) begin_motion(now);
}

/// The fingers stand, and the force limit holds.
void Client::begin_motion(Nanoseconds now) {
  const double way = wanted_.width - width_;
  const bool held = holds();
  // Another force on the same part: the limit is all there is to it.
  const bool presses_on = held && std::abs(way) > kPartLostDistance && way * (current_.width - width_) > 0.0;
  current_ = wanted_;
  if (presses_on) {
    answered_ = current_.sequence;
    return;
  }
  const bool gripped = !blocked_ && (grasp_ == GraspState::kHolding || grasp_ == GraspState::kPartLost);
  const Command command = gripped && way > 0.0 ? Command::kRelease : way < -kAtWidth ? Command::kGrasp : Command::kMove;
  blocked_ = part_lost_ = false;
  pressed_at_.reset();
  motion_ = command;
  ++counts_.motions;
  ask(command, motion_payload(command, {.width = current_.width, .speed = current_.speed}), now);
}

void Client::acknowledge_on_reset(Nanoseconds now) {
  if (!reset_.exchange(false) || step_ != Step::kRunning) return;
  refused_ = false;
  keep_refusal({});
  // A command that was dropped is never reported as carried out: the core gives another one.
  if (wanted_.sequence != current_.sequence) answered_ = 0;
  current_ = wanted_;
  ask(Command::kAcknowledge, "ack", now);
}

// -- What is reported ------------------------------------------------------------------------------------------------

Fault Client::fault() const {
  if (wrong_) return Fault::kWrongGripper;
  if (refused_) return Fault::kRefused;
  if (step_ == Step::kIdle) return ran_ ? Fault::kLost : Fault::kNotConnected;
  if (step_ != Step::kRunning) return Fault::kStarting;
  if ((flags_ & (kTemperatureFault | kPowerFault | kCurrentFault | kFingerFault)) != 0) return Fault::kHardware;
  if ((flags_ & kFastStopped) != 0) return Fault::kFastStop;
  if ((flags_ & kReferenced) == 0) return Fault::kNotReferenced;
  return Fault::kNone;
}

GripperState Client::state() {
  if (motion_ || stopping_ || !settled_ || interrupted_) return GripperState::kMoving;
  if (blocked_) {
    if (!pressed_at_) pressed_at_ = width_;
    part_lost_ = part_lost_ || std::abs(width_ - *pressed_at_) > kPartLostDistance;
    return part_lost_ ? GripperState::kLost : GripperState::kHolding;
  }
  switch (grasp_) {
    case GraspState::kHolding:
      return GripperState::kHolding;
    case GraspState::kPartLost:
      return GripperState::kLost;
    case GraspState::kGrasping:
    case GraspState::kReleasing:
    case GraspState::kPositioning:
      return GripperState::kMoving;
    case GraspState::kIdle:
    case GraspState::kNoPart:
    case GraspState::kError:
      break;
  }
  return GripperState::kIdle;
}

void Client::publish(Nanoseconds now) {
  const Fault why = fault();
  ++sample_.sequence;
  sample_.stamp = now - options_.transport;
  sample_.width = width_;
  sample_.speed = speed_;
  sample_.force = force_;
  sample_.state = state();
  sample_.command = answered_;
  sample_.ready = why == Fault::kNone;
  sample_.fault = static_cast<std::uint32_t>(why);
  samples_.publish(sample_);
  ++counts_.samples;
}

/// What is on the wire is in the digest of the network.
void Client::add_state(emulation::StateHash& hash) const {
  hash.add(static_cast<std::uint64_t>(step_) | static_cast<std::uint64_t>(grasp_) << 8 |
           static_cast<std::uint64_t>(motion_.value_or(Command{})) << 16 | std::uint64_t{stopping_} << 24 |
           std::uint64_t{settled_} << 25 | std::uint64_t{blocked_} << 26 | std::uint64_t{flags_} << 32);
  for (const std::uint64_t number : {sample_.sequence, current_.sequence, wanted_.sequence, answered_})
    hash.add(number);
  for (const double x : {width_, speed_, force_, limit_.value_or(-1.0), setting_.value_or(-1.0)}) hash.add(x);
  hash.add(heard_at_);
}

}  // namespace takt::hw::wsg
