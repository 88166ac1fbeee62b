#include "hw/cia402/protocol/canopen.h"

#include <array>

#include <fmt/format.h>

namespace takt::hw::cia402 {
namespace {

using Kind = SdoMessage::Kind;

// Command specifiers: the upper three bits of the first byte. Below them: expedited, sized, how many bytes are unused.
constexpr std::uint8_t kWriteRequest = 0x20, kReadRequest = 0x40, kReadReply = 0x40, kWriteReply = 0x60, kAbort = 0x80;
constexpr std::uint8_t kSpecifier = 0xE0, kExpedited = 0x02, kSized = 0x01;

/// In the order of their kinds.
constexpr std::array<std::uint8_t, 5> kSpecifiers{kReadRequest, kReadReply, kWriteRequest, kWriteReply, kAbort};

std::uint32_t command_of(const SdoMessage& message) {
  const std::uint32_t specifier = kSpecifiers[static_cast<std::size_t>(message.kind)];
  const bool has_data = message.kind == Kind::kReadAnswer || message.kind == Kind::kWrite;
  return has_data ? specifier | kExpedited | kSized | (4u - message.size) << 2 : specifier;
}

std::uint8_t command_in(const CanFrame& frame) { return static_cast<std::uint8_t>(get(frame.data, 0, 1)); }

SdoMessage message_of(const CanFrame& frame, Kind kind) {
  const auto index = static_cast<std::uint16_t>(get(frame.data, 1, 2));
  const auto sub = static_cast<std::uint8_t>(get(frame.data, 3, 1));
  return {.kind = kind, .id = {index, sub}, .size = 4, .value = get(frame.data, 4, 4)};
}

/// Expedited; a size that is not said is 4.
std::optional<SdoMessage> with_data(const CanFrame& frame, Kind kind) {
  const std::uint8_t command = command_in(frame);
  if ((command & kExpedited) == 0) return std::nullopt;
  SdoMessage message = message_of(frame, kind);
  if ((command & kSized) != 0) message.size = static_cast<std::uint8_t>(4 - (command >> 2 & 3));
  message.value = get(frame.data, 4, message.size);
  return message;
}

struct AbortText {
  SdoAbort code;
  const char* text;
};
constexpr AbortText kAbortTexts[] = {
    {SdoAbort::kUnknownCommand, "it does not know this transfer"},
    {SdoAbort::kNotReadable, "the object cannot be read"},
    {SdoAbort::kNotWritable, "the object cannot be written"},
    {SdoAbort::kNoObject, "it has no such object"},
    {SdoAbort::kNotMappable, "the object cannot be process data"},
    {SdoAbort::kTooLongForPdo, "the process data are too long"},
    {SdoAbort::kWrongLength, "the object has another length"},
    {SdoAbort::kNoSubindex, "it has no such subindex"},
    {SdoAbort::kOutOfRange, "the value is out of range"},
    {SdoAbort::kWrongState, "not in its present state"},
};

}  // namespace

std::uint32_t get(std::span<const std::byte> bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count && at + i < bytes.size(); ++i)
    value |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}

void put(std::uint32_t value, std::size_t count, std::span<std::byte> bytes, std::size_t at) {
  for (std::size_t i = 0; i < count && at + i < bytes.size(); ++i)
    bytes[at + i] = static_cast<std::byte>(value >> (8 * i));
}

CanFrame nmt_frame(NmtCommand command, NodeId node) {
  CanFrame frame{.id = kNmtId, .size = 2};
  put(static_cast<std::uint32_t>(command), 1, frame.data, 0);
  put(node, 1, frame.data, 1);
  return frame;
}

std::optional<NmtCommand> nmt_command(const CanFrame& frame, NodeId node) {
  if (frame.id != kNmtId || frame.size != 2) return std::nullopt;
  const std::uint32_t whom = get(frame.data, 1, 1);
  if (whom != 0 && whom != node) return std::nullopt;
  return static_cast<NmtCommand>(get(frame.data, 0, 1));
}

CanFrame heartbeat_frame(NodeId node, NmtState state) {
  CanFrame frame{.id = kHeartbeatId | node, .size = 1};
  put(static_cast<std::uint32_t>(state), 1, frame.data, 0);
  return frame;
}

std::optional<NmtState> heartbeat_state(const CanFrame& frame) {
  if (node_in(frame.id, kHeartbeatId) == 0 || frame.size != 1) return std::nullopt;
  return static_cast<NmtState>(get(frame.data, 0, 1));
}

CanFrame sync_frame() { return {.id = kSyncId, .size = 0}; }

CanFrame emergency_frame(NodeId node, std::uint16_t code, std::uint8_t error_register) {
  CanFrame frame{.id = kEmergencyId | node, .size = 8};
  put(code, 2, frame.data, 0);
  put(error_register, 1, frame.data, 2);
  return frame;
}

std::optional<std::uint16_t> emergency_code(const CanFrame& frame) {
  if (node_in(frame.id, kEmergencyId) == 0 || frame.size != 8) return std::nullopt;
  return static_cast<std::uint16_t>(get(frame.data, 0, 2));
}

std::string text_of_abort(std::uint32_t code) {
  for (const AbortText& row : kAbortTexts)
    if (static_cast<std::uint32_t>(row.code) == code) return fmt::format("{} ({:08X}h)", row.text, code);
  return fmt::format("abort {:08X}h", code);
}

CanFrame sdo_frame(std::uint32_t id, const SdoMessage& message) {
  CanFrame frame{.id = id, .size = 8};
  put(command_of(message), 1, frame.data, 0);
  put(message.id.index, 2, frame.data, 1);
  put(message.id.sub, 1, frame.data, 3);
  const bool has_value = message.kind != Kind::kRead && message.kind != Kind::kWriteAnswer;
  if (has_value) put(message.value, message.kind == Kind::kAbort ? 4u : message.size, frame.data, 4);
  return frame;
}

std::optional<SdoMessage> sdo_request(const CanFrame& frame) {
  if (node_in(frame.id, kSdoRequestId) == 0 || frame.size != 8) return std::nullopt;
  const std::uint8_t command = command_in(frame);
  if ((command & kSpecifier) == kReadRequest) return message_of(frame, Kind::kRead);
  if ((command & kSpecifier) == kWriteRequest) return with_data(frame, Kind::kWrite);
  return std::nullopt;
}

std::optional<SdoMessage> sdo_answer(const CanFrame& frame) {
  if (node_in(frame.id, kSdoAnswerId) == 0 || frame.size != 8) return std::nullopt;
  const std::uint8_t command = command_in(frame);
  if ((command & kSpecifier) == kReadReply) return with_data(frame, Kind::kReadAnswer);
  if ((command & kSpecifier) == kWriteReply) return message_of(frame, Kind::kWriteAnswer);
  if (command == kAbort) return message_of(frame, Kind::kAbort);
  return std::nullopt;
}

}  // namespace takt::hw::cia402
