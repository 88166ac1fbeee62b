#pragma once

#include <cstdint>
#include <string_view>

/// Numbers by which a controller says how it is, on every one of its interfaces.
namespace takt::hw::rtde {

enum class RobotMode : std::int32_t {
  kNoController = -1,
  kDisconnected = 0,
  kConfirmSafety = 1,
  kBooting = 2,
  kPowerOff = 3,
  kPowerOn = 4,
  kIdle = 5,  ///< powered, brakes closed
  kBackdrive = 6,
  kRunning = 7,  ///< brakes open: the only mode in which it moves
  kUpdatingFirmware = 8
};
/// As the dashboard writes it, such as "POWER_OFF".
[[nodiscard]] std::string_view name_of(RobotMode mode);

enum class SafetyMode : std::int32_t {
  kNormal = 1,
  kReduced = 2,
  kProtectiveStop = 3,
  kRecovery = 4,
  kSafeguardStop = 5,
  kSystemEmergencyStop = 6,
  kRobotEmergencyStop = 7,
  kViolation = 8,
  kFault = 9
};
[[nodiscard]] std::string_view name_of(SafetyMode mode);

enum class RuntimeState : std::uint32_t {
  kStopping = 0,
  kStopped = 1,
  kPlaying = 2,
  kPausing = 3,
  kPaused = 4,
  kResuming = 5
};

/// Bits of robot_status_bits.
inline constexpr std::uint32_t kPowerOnBit = 1u << 0, kProgramRunningBit = 1u << 1, kTeachBit = 1u << 2;
/// Bits of safety_status_bits.
inline constexpr std::uint32_t kNormalBit = 1u << 0, kReducedBit = 1u << 1, kProtectiveStopBit = 1u << 2,
                               kRecoveryBit = 1u << 3, kSafeguardBit = 1u << 4, kSystemEmergencyBit = 1u << 5,
                               kRobotEmergencyBit = 1u << 6, kEmergencyBit = 1u << 7, kViolationBit = 1u << 8,
                               kFaultBit = 1u << 9, kStoppedBySafetyBit = 1u << 10;
[[nodiscard]] std::uint32_t status_bits(SafetyMode mode);
/// The robot may move.
[[nodiscard]] constexpr bool allows_motion(SafetyMode mode) {
  return mode == SafetyMode::kNormal || mode == SafetyMode::kReduced || mode == SafetyMode::kRecovery;
}

}  // namespace takt::hw::rtde
