#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hw/wsg/protocol/packet.h"

/// What packets say: commands and their payloads, answers, states. Widths, speeds and forces in m, m/s, m/s^2 and N on
/// this side. Realtime: as of packet.h.
namespace takt::hw::wsg {

enum class Command : std::uint8_t {
  kLoop = 0x06,        ///< sends the payload back
  kDisconnect = 0x07,  ///< the client is about to leave
  kHome = 0x20,
  kMove = 0x21,
  kStop = 0x22,
  kFastStop = 0x23,
  kAcknowledge = 0x24,
  kGrasp = 0x25,
  kRelease = 0x26,
  kSetAcceleration = 0x30,
  kGetAcceleration = 0x31,
  kSetForce = 0x32,
  kGetForce = 0x33,
  kTare = 0x38,
  kSystemState = 0x40,
  kGraspState = 0x41,
  kWidth = 0x43,
  kSpeed = 0x44,
  kForce = 0x45,
  kTemperature = 0x46,
  kSystemInfo = 0x50,
  kLimits = 0x53
};

/// First word of each answer.
enum class Status : std::uint16_t {
  kSuccess = 0,
  kNotAvailable,
  kNoSensor,
  kNotInitialized,
  kAlreadyRunning,
  kFeatureNotSupported,
  kInconsistentData,
  kTimeout,
  kReadError,
  kWriteError,
  kInsufficientResources,
  kChecksumError,
  kNoParameterExpected,
  kNotEnoughParameters,
  kUnknownCommand,
  kFormatError,
  kAccessDenied,
  kAlreadyOpen,
  kFailed,
  kAborted,
  kInvalidHandle,
  kNotFound,
  kNotOpen,
  kIoError,
  kInvalidParameter,
  kIndexOutOfBounds,
  kPending,  ///< accepted; another answer comes when it is done
  kOverrun,
  kOutOfRange,
  kAxisBlocked,
  kFileExists
};
/// For people: "access denied". Realtime: any thread.
[[nodiscard]] std::string_view name_of(Status status);

enum class GraspState : std::uint8_t {
  kIdle = 0,
  kGrasping,
  kNoPart,
  kPartLost,
  kHolding,
  kReleasing,
  kPositioning,
  kError
};

/// Bits of the system state.
inline constexpr std::uint32_t kReferenced = 1u << 0, kMoving = 1u << 1, kBlockedMinus = 1u << 2,
                               kBlockedPlus = 1u << 3, kAxisStopped = 1u << 6, kTargetReached = 1u << 7,
                               kFastStopped = 1u << 12, kTemperatureFault = 1u << 14, kPowerFault = 1u << 15,
                               kCurrentFault = 1u << 16, kFingerFault = 1u << 17, kCommandFailure = 1u << 18;

struct Answer {
  Status status = Status::kSuccess;
  std::string_view parameters;  ///< of the packet, which it points into; only with kSuccess
};
/// @return nothing: the payload is too short to be an answer.
[[nodiscard]] std::optional<Answer> parse_answer(std::string_view payload);
void append_answer(std::string& out, Command command, Status status, std::string_view parameters = {});

/// A motion: kMove, kGrasp or kRelease. A move goes to a width and, with `stop_on_block` false, presses on what it
/// meets.
struct Motion {
  double width = 0.0;  ///< m
  double speed = 0.0;  ///< m/s
  bool stop_on_block = false;
  bool relative = false;  ///< kMove only: `width` is added to where the fingers are
};
[[nodiscard]] std::string motion_payload(Command command, const Motion& motion);
/// @return nothing: the payload is not that of the command
[[nodiscard]] std::optional<Motion> parse_motion(Command command, std::string_view payload);

/// Of kSystemState to kTemperature: answers by itself, each `period_ms`.
struct AutoUpdate {
  bool on = false, on_change_only = false;
  std::uint16_t period_ms = 0;
};
[[nodiscard]] std::string auto_update_payload(const AutoUpdate& update);
[[nodiscard]] std::optional<AutoUpdate> parse_auto_update(std::string_view payload);

/// One number: kSetAcceleration in m/s^2, kSetForce in N, kWidth in m, kSpeed in m/s, kForce in N.
[[nodiscard]] std::string number_payload(Command command, double value);
[[nodiscard]] std::optional<double> parse_number(Command command, std::string_view payload);

/// What the gripper can do.
struct Limits {
  double stroke = 0.0;                                  ///< m
  double speed_min = 0.0, speed_max = 0.0;              ///< m/s
  double acceleration_min = 0.0, acceleration_max = 0;  ///< m/s^2
  double force_min = 0.0, force_nominal = 0.0, force_overdrive = 0.0;
};
[[nodiscard]] std::string limits_payload(const Limits& limits);
[[nodiscard]] std::optional<Limits> parse_limits(std::string_view payload);

}  // namespace takt::hw::wsg
