#include "hw/rtde/modes.h"

#include <array>

namespace takt::hw::rtde {

namespace {

constexpr std::array<std::string_view, 10> kRobotModes = {
    "NO_CONTROLLER", "DISCONNECTED", "CONFIRM_SAFETY", "BOOTING", "POWER_OFF",
    "POWER_ON",      "IDLE",         "BACKDRIVE",      "RUNNING", "UPDATING_FIRMWARE"};
constexpr std::array<std::string_view, 9> kSafetyModes = {"NORMAL",
                                                          "REDUCED",
                                                          "PROTECTIVE_STOP",
                                                          "RECOVERY",
                                                          "SAFEGUARD_STOP",
                                                          "SYSTEM_EMERGENCY_STOP",
                                                          "ROBOT_EMERGENCY_STOP",
                                                          "VIOLATION",
                                                          "FAULT"};
constexpr std::array<std::uint32_t, 9> kSafetyBits = {kNormalBit,
                                                      kNormalBit | kReducedBit,
                                                      kProtectiveStopBit | kStoppedBySafetyBit,
                                                      kRecoveryBit | kStoppedBySafetyBit,
                                                      kSafeguardBit | kStoppedBySafetyBit,
                                                      kSystemEmergencyBit | kEmergencyBit | kStoppedBySafetyBit,
                                                      kRobotEmergencyBit | kEmergencyBit | kStoppedBySafetyBit,
                                                      kViolationBit | kStoppedBySafetyBit,
                                                      kFaultBit | kStoppedBySafetyBit};

template <std::size_t count>
std::string_view name_in(const std::array<std::string_view, count>& names, std::int32_t at) {
  return at >= 0 && at < static_cast<std::int32_t>(count) ? names[static_cast<std::size_t>(at)] : "UNDEFINED";
}

}  // namespace

std::string_view name_of(RobotMode mode) { return name_in(kRobotModes, static_cast<std::int32_t>(mode) + 1); }
std::string_view name_of(SafetyMode mode) { return name_in(kSafetyModes, static_cast<std::int32_t>(mode) - 1); }

std::uint32_t status_bits(SafetyMode mode) {
  const auto at = static_cast<std::size_t>(static_cast<std::int32_t>(mode) - 1);
  return at < kSafetyBits.size() ? kSafetyBits[at] : kFaultBit | kStoppedBySafetyBit;
}

}  // namespace takt::hw::rtde
