#pragma once

#include <cstdint>
#include <string_view>

namespace takt::hw::cia402 {

/// States of a drive's power stage (IEC 61800-7-201, "power drive system finite state automaton").
enum class DriveState : std::uint8_t {
  kNotReadyToSwitchOn,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReactionActive,
  kFault
};
/// "operation enabled".
[[nodiscard]] std::string_view name_of(DriveState state);

// Bits of the status word (6041h) beside those of the state.
inline constexpr std::uint16_t kVoltageEnabled = 1u << 4;
inline constexpr std::uint16_t kRemote = 1u << 9;
inline constexpr std::uint16_t kFollowsTarget = 1u << 12;  ///< in mode CSP: the drive follows the target position

/// What a status word says. @return kNotReadyToSwitchOn for a word that no state has. Realtime: cyclic.
[[nodiscard]] DriveState state_of(std::uint16_t status);
/// The bits of a status word that say the state. Realtime: cyclic.
[[nodiscard]] std::uint16_t status_of(DriveState state);

// Control words (6040h).
inline constexpr std::uint16_t kDisableVoltage = 0x0000;
inline constexpr std::uint16_t kQuickStopWord = 0x0002;
inline constexpr std::uint16_t kShutdown = 0x0006;
inline constexpr std::uint16_t kSwitchOn = 0x0007;
inline constexpr std::uint16_t kEnableOperation = 0x000F;
inline constexpr std::uint16_t kFaultReset = 0x0080;

/// What a drive does with a control word: the state that it leads to, one transition at a time. What the drive does by
/// itself (end of a quick stop, faults) is not here.
/// @param before  the control word that came before: a fault is reset by a rising edge. Realtime: cyclic.
[[nodiscard]] DriveState next_state(DriveState state, std::uint16_t control, std::uint16_t before);

/// What a master wants of a drive.
enum class Wanted : std::uint8_t {
  kOff,        ///< voltage disabled at once: the brakes close
  kQuickStop,  ///< brakes by itself, then off
  kOn          ///< operation enabled
};
/// The control word that brings a drive one step on. A fault is not reset by it. Realtime: cyclic.
[[nodiscard]] std::uint16_t control_for(Wanted wanted, DriveState state);

}  // namespace takt::hw::cia402
