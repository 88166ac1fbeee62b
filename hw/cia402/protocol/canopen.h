#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "hw/can/frame.h"
#include "hw/cia402/protocol/objects.h"

/// Messages of CANopen (CiA 301), as far as a master and its drives need them: NMT, SYNC, emergency, process data,
/// expedited SDO, heartbeat. Little endian. Realtime: cyclic unless it says otherwise.
namespace takt::hw::cia402 {

using NodeId = std::uint8_t;  ///< 1 to 127
inline constexpr NodeId kMasterNode = 127;

// Identifiers: a function, and the number of the node.
inline constexpr std::uint32_t kNmtId = 0x000, kSyncId = 0x080, kEmergencyId = 0x080, kInputs1Id = 0x180,
                               kOutputs1Id = 0x200, kInputs2Id = 0x280, kOutputs2Id = 0x300, kSdoAnswerId = 0x580,
                               kSdoRequestId = 0x600, kHeartbeatId = 0x700;
/// 1 to 127 if the identifier is this function's of some node, else 0.
[[nodiscard]] constexpr NodeId node_in(std::uint32_t id, std::uint32_t function) {
  return (id & ~0x7Fu) == function ? static_cast<NodeId>(id & 0x7F) : NodeId{0};
}

/// An unsigned number of `count` bytes, at most 4; what is not there is 0.
[[nodiscard]] std::uint32_t get(std::span<const std::byte> bytes, std::size_t at, std::size_t count);
void put(std::uint32_t value, std::size_t count, std::span<std::byte> bytes, std::size_t at);

// -- Network management
// ------------------------------------------------------------------------------------------------
enum class NmtCommand : std::uint8_t {
  kStart = 1,
  kStop = 2,
  kEnterPreOperational = 128,
  kResetNode = 129,
  kResetCommunication = 130
};
enum class NmtState : std::uint8_t { kBootUp = 0, kStopped = 4, kOperational = 5, kPreOperational = 127 };
[[nodiscard]] CanFrame nmt_frame(NmtCommand command, NodeId node);
/// The command of an NMT message, if it is one for this node: its own number, or 0 for all.
[[nodiscard]] std::optional<NmtCommand> nmt_command(const CanFrame& frame, NodeId node);
[[nodiscard]] CanFrame heartbeat_frame(NodeId node, NmtState state);
/// The state in a heartbeat of any node.
[[nodiscard]] std::optional<NmtState> heartbeat_state(const CanFrame& frame);
[[nodiscard]] CanFrame sync_frame();

// -- Emergencies
// -------------------------------------------------------------------------------------------------------
[[nodiscard]] CanFrame emergency_frame(NodeId node, std::uint16_t code, std::uint8_t error_register);
/// The error code in an emergency message of any node.
[[nodiscard]] std::optional<std::uint16_t> emergency_code(const CanFrame& frame);

// -- Service data: expedited transfers
// ---------------------------------------------------------------------------------
enum class SdoAbort : std::uint32_t {
  kUnknownCommand = 0x0504'0001,
  kNotReadable = 0x0601'0001,
  kNotWritable = 0x0601'0002,
  kNoObject = 0x0602'0000,
  kNotMappable = 0x0604'0041,
  kTooLongForPdo = 0x0604'0042,
  kWrongLength = 0x0607'0010,
  kNoSubindex = 0x0609'0011,
  kOutOfRange = 0x0609'0030,
  kWrongState = 0x0800'0022
};
/// Words for an abort code. Realtime: setup.
[[nodiscard]] std::string text_of_abort(std::uint32_t code);

/// A request or an answer.
struct SdoMessage {
  enum class Kind : std::uint8_t { kRead, kReadAnswer, kWrite, kWriteAnswer, kAbort };
  Kind kind = Kind::kRead;
  ObjectId id;
  std::uint8_t size = 4;    ///< bytes of `value` in kReadAnswer and kWrite: 1 to 4
  std::uint32_t value = 0;  ///< or the abort code
};
/// @param id  kSdoRequestId or kSdoAnswerId, and the node
[[nodiscard]] CanFrame sdo_frame(std::uint32_t id, const SdoMessage& message);
/// What a server is asked. @return nothing for what is no expedited transfer of eight bytes
[[nodiscard]] std::optional<SdoMessage> sdo_request(const CanFrame& frame);
/// What a server answers.
[[nodiscard]] std::optional<SdoMessage> sdo_answer(const CanFrame& frame);

}  // namespace takt::hw::cia402
