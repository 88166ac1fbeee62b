#include "hw/emulators/wsg/emulator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace takt::hw::wsg {
namespace {

using device::GripperState;

constexpr double kAccelerationMin = 0.1;     // m/s^2
constexpr std::uint16_t kTemperature = 350;  // 0.1 deg C
constexpr std::uint8_t kType = 1, kHardware = 6;
constexpr std::uint16_t kFirmware = 0x4000;  // 4.0.0
constexpr std::uint32_t kSerialNumber = 0;
constexpr std::size_t kMostNewsKept = 64;

bool moves_fingers(Command command) {
  switch (command) {
    case Command::kHome:
    case Command::kMove:
    case Command::kGrasp:
    case Command::kRelease:
      return true;
    default:
      return false;
  }
}

}  // namespace

Emulator::Emulator(const EmulatorOptions& options, std::shared_ptr<const device::GripperDescription> description,
                   Network& network, std::shared_ptr<device::GripperBackend> machine)
    : options_(options),
      description_(std::move(description)),
      network_(network),
      machine_(std::move(machine)),
      referenced_(options.referenced),
      acceleration_(description_->acceleration),
      force_limit_(description_->force_max) {}

Result<void> Emulator::listen(const Endpoint& local) {
  auto listener = network_.listen(local);
  if (!listener) return std::unexpected(listener.error());
  listener_ = std::move(*listener);
  return {};
}

std::vector<std::string> Emulator::news() { return std::exchange(news_, {}); }

void Emulator::advance(Nanoseconds now) {
  look();
  serve();
  update(now);
}

// -- Clients ---------------------------------------------------------------------------------------------------------

void Emulator::accept() {
  while (auto link = listener_->accept()) {
    if (client_ != nullptr) {
      if (news_.size() < kMostNewsKept) news_.push_back("a second client was turned away");
      continue;
    }
    client_ = std::make_unique<Client>();
    client_->link = ByteLink(std::move(link));
  }
}

void Emulator::drop_client() {
  const bool announced = client_->leaves;
  client_.reset();
  updates_ = {};
  if (announced || !options_.stop_on_leave) return;
  if (news_.size() < kMostNewsKept) news_.push_back("the client has gone without a word: FAST STOP");
  abort_motion();
  fast_stopped_ = true;
}

void Emulator::restart() {
  client_.reset();
  updates_ = {};
  abort_motion();
  referenced_ = options_.referenced;
  fast_stopped_ = false;
  fault_flags_ = motion_flags_ = 0;
  acceleration_ = description_->acceleration;
  force_limit_ = description_->force_max;
}

void Emulator::serve() {
  if (listener_ == nullptr) return;
  const auto gone = [this] { return client_ != nullptr && !client_->link.open(); };
  if (gone()) drop_client();
  accept();
  if (client_ == nullptr) return;
  client_->link.receive([this](std::string_view bytes) { client_->parser.feed(bytes); });
  while (const auto packet = client_->parser.next()) handle(*packet);
  client_->link.flush();
  if (gone()) drop_client();
}

void Emulator::answer(Command command, Status status, std::string_view parameters) {
  if (client_ == nullptr) return;
  std::string packet;
  append_answer(packet, command, status, parameters);
  client_->link.send(packet);
}

void Emulator::handle(const Packet& packet) {
  const auto command = static_cast<Command>(packet.command);
  if (!packet.intact) return answer(command, Status::kChecksumError);
  if (moves_fingers(command)) return handle_motion(command, packet);
  if (handle_setting(command, packet)) return;
  switch (command) {
    case Command::kLoop:
      return answer(command, Status::kSuccess, packet.payload);
    case Command::kDisconnect:
      client_->leaves = true;
      return answer(command, Status::kSuccess);
    case Command::kStop:
    case Command::kFastStop:
      if (!packet.payload.empty()) return answer(command, Status::kNoParameterExpected);
      return handle_stop(command);
    case Command::kAcknowledge:
      if (packet.payload != "ack") return answer(command, Status::kFormatError);
      fast_stopped_ = false;
      fault_flags_ = 0;
      if (grasp_ == GraspState::kError) grasp_ = GraspState::kIdle;
      return answer(command, Status::kSuccess);
    case Command::kTare:
      return answer(command, Status::kNotAvailable);
    default:
      break;
  }
  if (state_payload(command)) return handle_state(command, packet);
  answer(command, Status::kUnknownCommand);
}

/// Settings, and what never changes. @return false: the command is none of these
bool Emulator::handle_setting(Command command, const Packet& packet) {
  const device::GripperDescription& d = *description_;
  switch (command) {
    case Command::kSetAcceleration:
    case Command::kSetForce: {
      const auto value = parse_number(command, packet.payload);
      if (!value || !std::isfinite(*value)) {
        answer(command, value ? Status::kInvalidParameter : Status::kFormatError);
      } else if (command == Command::kSetAcceleration) {
        acceleration_ = std::clamp(*value, kAccelerationMin, std::max(kAccelerationMin, d.acceleration));
        answer(command, Status::kSuccess);
      } else {
        force_limit_ = std::clamp(*value, d.force_min, d.force_max);
        // What is held is held with it from now on.
        if (!motion_ && grasp_ == GraspState::kHolding) go(set_point_.width, set_point_.speed);
        answer(command, Status::kSuccess);
      }
      return true;
    }
    case Command::kGetAcceleration:
    case Command::kGetForce:
    case Command::kSystemInfo:
    case Command::kLimits:
      break;
    default:
      return false;
  }
  if (!packet.payload.empty()) {
    answer(command, Status::kNoParameterExpected);
    return true;
  }
  std::string payload;
  if (command == Command::kGetAcceleration) payload = number_payload(command, acceleration_);
  if (command == Command::kGetForce) payload = number_payload(command, force_limit_);
  if (command == Command::kLimits)
    payload = limits_payload(
        {d.stroke, d.speed_min, d.speed_max, kAccelerationMin, d.acceleration, d.force_min, d.force_max, d.force_max});
  if (command == Command::kSystemInfo) {
    append(payload, kType);
    append(payload, kHardware);
    append(payload, kFirmware);
    append(payload, kSerialNumber);
  }
  answer(command, Status::kSuccess, payload);
  return true;
}

// -- States ----------------------------------------------------------------------------------------------------------

std::uint32_t Emulator::flags() const {
  std::uint32_t flags = fault_flags_ | motion_flags_;
  if (referenced_) flags |= kReferenced;
  if (motion_) flags |= kMoving;
  if (fast_stopped_) flags |= kFastStopped;
  return flags;
}

std::optional<std::string> Emulator::state_payload(Command command) const {
  std::string payload;
  switch (command) {
    case Command::kSystemState:
      append(payload, flags());
      break;
    case Command::kGraspState:
      append(payload, static_cast<std::uint8_t>(fault_flags_ != 0 || fast_stopped_ ? GraspState::kError : grasp_));
      break;
    case Command::kWidth:
      return number_payload(command, sample_.width);
    case Command::kSpeed:
      return number_payload(command, sample_.speed);
    case Command::kForce:
      return number_payload(command, sample_.force);
    case Command::kTemperature:
      append(payload, kTemperature);
      break;
    default:
      return std::nullopt;
  }
  return payload;
}

void Emulator::handle_state(Command command, const Packet& packet) {
  const auto wanted = parse_auto_update(packet.payload);
  if (!wanted) return answer(command, Status::kFormatError);
  Update& one = updates_[static_cast<std::size_t>(command) - kFirstUpdate];
  one = {wanted->on, wanted->on_change_only, std::max<Nanoseconds>(1, wanted->period_ms) * kMillisecond, 0, {}};
  answer(command, Status::kSuccess, *state_payload(command));
}

void Emulator::update(Nanoseconds now) {
  // The width last: it completes what belongs together.
  static constexpr Command kOrder[] = {Command::kSystemState, Command::kGraspState,  Command::kSpeed,
                                       Command::kForce,       Command::kTemperature, Command::kWidth};
  for (const Command command : kOrder) {
    Update& one = updates_[static_cast<std::size_t>(command) - kFirstUpdate];
    if (!one.on || now < one.due || client_ == nullptr) continue;
    one.due = now + one.period;
    const std::string payload = *state_payload(command);
    if (one.on_change_only && payload == one.sent) continue;
    one.sent = payload;
    answer(command, Status::kSuccess, payload);
  }
  if (client_ != nullptr) client_->link.flush();
}

// -- Motions ---------------------------------------------------------------------------------------------------------

void Emulator::go(double width, double speed) {
  const device::GripperDescription& d = *description_;
  set_point_ = {.sequence = set_point_.sequence + 1,
                .width = std::clamp(width, 0.0, d.stroke),
                .speed = std::clamp(speed, d.speed_min, d.speed_max),
                .force = force_limit_};
  machine_->write(set_point_);
}

void Emulator::stand() { go(sample_.width, description_->speed_max); }

void Emulator::handle_motion(Command command, const Packet& packet) {
  Motion motion;
  if (command == Command::kHome) {
    if (packet.payload.size() != 1) return answer(command, Status::kFormatError);
    motion = {.width = description_->stroke, .speed = description_->speed_max, .stop_on_block = true};
  } else {
    const auto parsed = parse_motion(command, packet.payload);
    if (!parsed) return answer(command, Status::kFormatError);
    motion = *parsed;
  }
  if (!std::isfinite(motion.width) || !std::isfinite(motion.speed)) return answer(command, Status::kInvalidParameter);
  if (fast_stopped_ || fault_flags_ != 0) return answer(command, Status::kAccessDenied);
  if (motion_ || stop_asked_) return answer(command, Status::kAlreadyRunning);
  if (!referenced_ && command != Command::kHome) return answer(command, Status::kNotInitialized);
  motion_ = command;
  motion_flags_ = 0;
  stop_on_block_ = motion.stop_on_block;
  grasp_ = command == Command::kGrasp     ? GraspState::kGrasping
           : command == Command::kRelease ? GraspState::kReleasing
                                          : GraspState::kPositioning;
  go(motion.width + (motion.relative ? sample_.width : 0.0), motion.speed);
  answer(command, Status::kPending);
}

void Emulator::abort_motion() {
  if (!motion_) return;
  const Command command = *std::exchange(motion_, std::nullopt);
  grasp_ = GraspState::kIdle;
  motion_flags_ = kAxisStopped;
  stand();
  answer(command, Status::kAborted);
}

/// Fingers that hold a part go on holding it.
void Emulator::handle_stop(Command command) {
  if (command == Command::kFastStop) {
    abort_motion();
    fast_stopped_ = true;
    return answer(command, Status::kSuccess);
  }
  if (!motion_) return answer(command, Status::kSuccess);
  abort_motion();
  stop_asked_ = true;
  answer(command, Status::kPending);
}

void Emulator::look() {
  if (set_point_.sequence > 0) machine_->write(set_point_);
  if (!machine_->read(sample_)) return;
  if (set_point_.sequence == 0 || sample_.command != set_point_.sequence) return;
  if (grasp_ == GraspState::kHolding && !motion_ && sample_.state == GripperState::kLost)
    grasp_ = GraspState::kPartLost;
  if (sample_.state == GripperState::kMoving) return;
  if (std::exchange(stop_asked_, false)) answer(Command::kStop, Status::kSuccess);
  if (motion_) finish_motion();
}

void Emulator::finish_motion() {
  const Command command = *std::exchange(motion_, std::nullopt);
  const bool met = sample_.state == GripperState::kHolding;
  if (command == Command::kGrasp) {
    grasp_ = met ? GraspState::kHolding : GraspState::kNoPart;
    return answer(command, met ? Status::kSuccess : Status::kFailed);
  }
  grasp_ = GraspState::kIdle;
  if (!met) {
    if (command == Command::kHome) referenced_ = true;
    motion_flags_ = kTargetReached;
    return answer(command, Status::kSuccess);
  }
  motion_flags_ = set_point_.width < sample_.width ? kBlockedMinus : kBlockedPlus;
  if (stop_on_block_) stand();
  answer(command, Status::kAxisBlocked);
}

}  // namespace takt::hw::wsg
