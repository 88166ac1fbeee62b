#include "hw/emulators/cia402/node.h"

#include <utility>

namespace takt::hw::cia402 {
namespace {

using Kind = SdoMessage::Kind;

constexpr std::uint32_t kOff = 1u << 31;  // of an identifier: this process data message does not exist
// What makes an identifier of the word that masters write: bit 30 is about remote frames, which nobody sends here.
constexpr std::uint32_t kIdentifier = kOff | 0x7FF;
constexpr std::uint16_t kOutputParameters = 0x1400, kOutputMapping = 0x1600, kInputParameters = 0x1800,
                        kInputMapping = 0x1A00;
constexpr std::uint8_t kMostMapped = 4;

bool is_mapping(std::uint16_t index) { return (index & ~1u) == kOutputMapping || (index & ~1u) == kInputMapping; }
bool is_parameters(std::uint16_t index) {
  return (index & ~1u) == kOutputParameters || (index & ~1u) == kInputParameters;
}

MappedObject mapped(std::uint32_t word) {
  return {{static_cast<std::uint16_t>(word >> 16), static_cast<std::uint8_t>(word >> 8)},
          static_cast<std::uint8_t>(word)};
}

}  // namespace

Node::Node(NodeId id, const DriveOptions& options, Send send) : id_(id), options_(options), send_(std::move(send)) {
  fill_dictionary();
}

void Node::fill_dictionary() {
  objects_ = {};
  fill_communication();
  drive_ = std::make_unique<Drive>(objects_, options_);
}

/// As a node has it that nobody has set up.
void Node::fill_communication() {
  using Access = Dictionary::Access;
  objects_.add(kDeviceType, {.access = Access::kConstant, .value = 0x0002'0000 | kProfileOfDrives});
  objects_.add(kErrorRegister, {.size = 1, .access = Access::kReadOnly});
  objects_.add(kSyncCobId, {.lowest = kSyncId, .highest = kSyncId, .value = kSyncId});
  objects_.add(kSyncPeriod, {.lowest = 0});
  objects_.add(kConsumedHeartbeat, {.lowest = 0});
  objects_.add(kProducedHeartbeat, {.size = 2, .lowest = 0, .highest = UINT16_MAX});
  objects_.add(kVendor, {.access = Access::kConstant, .value = 0});
  objects_.add(kProduct, {.access = Access::kConstant, .value = 0x402});
  for (const std::uint16_t number : {0, 1}) {
    const auto parameters = [&](std::uint16_t index, std::uint32_t id) {
      objects_.add({index, 1}, {.lowest = 0, .value = kOff | id | id_});
      objects_.add({index, 2}, {.size = 1, .lowest = 0, .highest = 255, .value = 255});
    };
    parameters(static_cast<std::uint16_t>(kOutputParameters + number), number == 0 ? kOutputs1Id : kOutputs2Id);
    parameters(static_cast<std::uint16_t>(kInputParameters + number), number == 0 ? kInputs1Id : kInputs2Id);
    for (const std::uint16_t base : {kOutputMapping, kInputMapping}) {
      const auto index = static_cast<std::uint16_t>(base + number);
      objects_.add({index, 0}, {.size = 1, .lowest = 0, .highest = kMostMapped});
      for (std::uint8_t sub = 1; sub <= kMostMapped; ++sub) objects_.add({index, sub}, {.lowest = 0});
    }
  }
}

void Node::restart(Nanoseconds now) {
  state_ = NmtState::kBootUp;
  brakes_ = drive_->at(now).dq != 0.0;
  used_ = came_ = 0;
  targeted_ = false;
  fill_dictionary();
  master_heard_ = -1;
  pass(now);
}

// -- Network management
// ------------------------------------------------------------------------------------------------

void Node::take(const CanFrame& frame, Nanoseconds now) {
  if (state_ == NmtState::kBootUp) return;
  if (const auto command = nmt_command(frame, id_)) return obey(*command, now);
  if (frame.id == kSyncId) return begin_cycle(now);
  if (node_in(frame.id, kHeartbeatId) != 0) return hear_heartbeat(frame, now);
  if (frame.id == (kSdoRequestId | id_) && state_ != NmtState::kStopped) {
    const auto request = sdo_request(frame);
    if (request) return serve(*request);
    const SdoMessage abort{Kind::kAbort, {}, 4, static_cast<std::uint32_t>(SdoAbort::kUnknownCommand)};
    return send_(sdo_frame(kSdoAnswerId | id_, abort));
  }
  if (state_ == NmtState::kOperational) take_outputs(frame);
}

void Node::obey(NmtCommand command, Nanoseconds now) {
  switch (command) {
    case NmtCommand::kStart:
      state_ = NmtState::kOperational;
      break;
    case NmtCommand::kStop:
      leave_operation(NmtState::kStopped, now);
      break;
    case NmtCommand::kEnterPreOperational:
      leave_operation(NmtState::kPreOperational, now);
      break;
    case NmtCommand::kResetNode:
      restart(now);
      break;
    case NmtCommand::kResetCommunication:
      leave_operation(NmtState::kBootUp, now);
      fill_communication();
      master_heard_ = -1;
      pass(now);
      break;
  }
}

/// Without process data nobody leads the drive any more.
void Node::leave_operation(NmtState state, Nanoseconds now) {
  const bool led = state_ == NmtState::kOperational && drive_->state() == DriveState::kOperationEnabled;
  state_ = state;
  used_ = came_ = 0;
  targeted_ = false;
  if (led) drive_->fail(kErrorOutputsMissing, now);
}

void Node::hear_heartbeat(const CanFrame& frame, Nanoseconds now) {
  const auto watched = static_cast<NodeId>(objects_.value(kConsumedHeartbeat) >> 16);
  if (node_in(frame.id, kHeartbeatId) == watched) master_heard_ = now;
}

void Node::watch_master(Nanoseconds now) {
  const Nanoseconds most = (objects_.value(kConsumedHeartbeat) & 0xFFFF) * kMillisecond;
  if (master_heard_ < 0 || most == 0 || now - master_heard_ <= most) return;
  master_heard_ = -1;
  if (drive_->state() == DriveState::kOperationEnabled) drive_->fail(kErrorHeartbeat, now);
  if (state_ == NmtState::kOperational) state_ = NmtState::kPreOperational;
}

void Node::pass(Nanoseconds now) {
  if (state_ == NmtState::kBootUp) {
    send_(heartbeat_frame(id_, NmtState::kBootUp));
    state_ = NmtState::kPreOperational;
  }
  if (measurable_) {
    drive_->pass(now);
  } else {
    drive_->suspend(now);
  }
  watch_master(now);
  const Nanoseconds period = objects_.value(kProducedHeartbeat) * kMillisecond;
  if (period > 0 && now >= next_heartbeat_) {
    next_heartbeat_ = now + period;
    send_(heartbeat_frame(id_, state_));
  }
  send_errors();
}

void Node::send_errors() {
  const auto code = drive_->take_error();
  if (!code) return;
  constexpr std::uint8_t kGenericError = 1;
  objects_.set(kErrorRegister, *code == 0 ? 0 : kGenericError);
  send_(emergency_frame(id_, *code, *code == 0 ? std::uint8_t{0} : kGenericError));
}

// -- Service data
// ------------------------------------------------------------------------------------------------------

void Node::serve(const SdoMessage& request) {
  SdoMessage answer{.kind = Kind::kAbort, .id = request.id};
  if (const auto refused = refuse(request)) {
    answer.value = static_cast<std::uint32_t>(*refused);
  } else if (request.kind == Kind::kWrite) {
    answer.kind = Kind::kWriteAnswer;
    objects_.set(request.id, request.value);
    if (request.id == kTargetPosition) drive_->take_outputs();
  } else {
    if (measurable_) drive_->report();  // what it measures, whether or not process data run
    answer.kind = Kind::kReadAnswer;
    answer.size = objects_.find(request.id)->size;
    answer.value = objects_.value(request.id);
  }
  send_(sdo_frame(kSdoAnswerId | id_, answer));
}

std::optional<SdoAbort> Node::refuse(const SdoMessage& request) const {
  if (request.kind == Kind::kWrite) {
    if (const auto refused = objects_.refuse_write(request.id, request.size, request.value)) return refused;
    if (is_mapping(request.id.index)) return refuse_mapping(request);
    // What is sent and when is agreed before the process data run.
    if (is_parameters(request.id.index) && state_ == NmtState::kOperational) return SdoAbort::kWrongState;
    return std::nullopt;
  }
  if (objects_.find(request.id) != nullptr) return std::nullopt;
  const auto reason = objects_.refuse_write(request.id, request.size, request.value);
  return reason.value_or(SdoAbort::kNoObject);
}

/// Objects are mapped while the message is empty; then their number makes it one (CiA 301, 7.5.2.36).
std::optional<SdoAbort> Node::refuse_mapping(const SdoMessage& request) const {
  const auto [index, sub] = request.id;
  if (state_ == NmtState::kOperational) return SdoAbort::kWrongState;
  if (sub > 0) {
    if (objects_.value({index, 0}) != 0) return SdoAbort::kWrongState;
    const MappedObject entry = mapped(request.value);
    const Dictionary::Object* object = objects_.find(entry.id);
    if (object == nullptr) return SdoAbort::kNoObject;
    const bool writes = index < kInputParameters && object->access != Dictionary::Access::kReadWrite;
    if (!object->mappable || entry.bits != 8 * object->size || writes) return SdoAbort::kNotMappable;
    return std::nullopt;
  }
  unsigned bits = 0;
  for (std::uint8_t i = 1; i <= request.value; ++i) bits += mapped(objects_.value({index, i})).bits;
  if (bits > 64) return SdoAbort::kTooLongForPdo;
  return std::nullopt;
}

// -- Process data
// ------------------------------------------------------------------------------------------------------

/// A set point is there with its target, in whichever message that is mapped, and with all messages that this master
/// has sent so far: of a new target with an old velocity nobody knows what is meant.
void Node::take_outputs(const CanFrame& frame) {
  for (const std::uint16_t number : {0, 1}) {
    const std::uint32_t id = objects_.value({static_cast<std::uint16_t>(kOutputParameters + number), 1});
    if (frame.id != (id & kIdentifier)) continue;
    const auto mapping = static_cast<std::uint16_t>(kOutputMapping + number);
    const std::uint32_t count = objects_.value({mapping, 0});
    std::size_t size = 0;
    for (std::uint8_t i = 1; i <= count; ++i) size += mapped(objects_.value({mapping, i})).bits / 8;
    if (count == 0 || frame.size < size) continue;  // too short: as if it had not come
    std::size_t at = 0;
    for (std::uint8_t i = 1; i <= count; ++i) {
      const MappedObject entry = mapped(objects_.value({mapping, i}));
      objects_.set(entry.id, get(frame.data, at, entry.bits / 8));
      targeted_ = targeted_ || entry.id == kTargetPosition;
      at += entry.bits / 8;
    }
    came_ |= 1u << number;
    used_ |= 1u << number;
  }
  if (targeted_ && came_ == used_) drive_->take_outputs();
}

void Node::begin_cycle(Nanoseconds now) {
  if (!measurable_ || state_ != NmtState::kOperational) return;
  came_ = 0;
  targeted_ = false;
  drive_->begin_cycle(now);
  drive_->report();
  send_errors();
  for (const std::uint16_t number : {0, 1}) send_inputs(number);
}

void Node::send_inputs(std::uint16_t number) {
  const auto mapping = static_cast<std::uint16_t>(kInputMapping + number);
  const std::uint32_t id = objects_.value({static_cast<std::uint16_t>(kInputParameters + number), 1});
  CanFrame frame{.id = id & kIdentifier};
  const std::uint32_t count = objects_.value({mapping, 0});
  if ((frame.id & kOff) != 0 || count == 0) return;
  for (std::uint8_t i = 1; i <= count; ++i) {
    const MappedObject entry = mapped(objects_.value({mapping, i}));
    put(objects_.value(entry.id), entry.bits / 8, frame.data, frame.size);
    frame.size = static_cast<std::uint8_t>(frame.size + entry.bits / 8);
  }
  send_(frame);
}

}  // namespace takt::hw::cia402
