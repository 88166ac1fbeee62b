#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <string_view>

/// Objects of the dictionary that master and drives use, and the process data that they agree on.
namespace takt::hw::cia402 {

/// Index and subindex of an object.
struct ObjectId {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  auto operator<=>(const ObjectId&) const = default;
};

// CiA 301, communication.
inline constexpr ObjectId kDeviceType{0x1000, 0}, kErrorRegister{0x1001, 0}, kSyncCobId{0x1005, 0},
    kSyncPeriod{0x1006, 0}, kConsumedHeartbeat{0x1016, 1}, kProducedHeartbeat{0x1017, 0}, kVendor{0x1018, 1},
    kProduct{0x1018, 2};
// CiA 402, the drive.
inline constexpr ObjectId kAbortOption{0x6007, 0}, kErrorCode{0x603F, 0}, kControlWord{0x6040, 0},
    kStatusWord{0x6041, 0}, kQuickStopOption{0x605A, 0}, kFaultReactionOption{0x605E, 0}, kMode{0x6060, 0},
    kModeDisplay{0x6061, 0}, kPosition{0x6064, 0}, kVelocity{0x606C, 0}, kRatedTorque{0x6076, 0}, kTorque{0x6077, 0},
    kTargetPosition{0x607A, 0}, kLowestPosition{0x607D, 1}, kHighestPosition{0x607D, 2}, kQuickStopRamp{0x6085, 0},
    kEncoderIncrements{0x608F, 1}, kEncoderTurns{0x608F, 2}, kGearMotorTurns{0x6091, 1}, kGearShaftTurns{0x6091, 2},
    kVelocityOffset{0x60B1, 0}, kCyclePeriod{0x60C2, 1}, kCycleExponent{0x60C2, 2}, kSupportedModes{0x6502, 0};

inline constexpr std::uint32_t kProfileOfDrives = 402;  ///< low half of the device type
inline constexpr std::int8_t kCyclicPosition = 8;       ///< mode CSP
inline constexpr std::uint32_t kHasCyclicPosition = 1u << 7;

/// An object in a process data message.
struct MappedObject {
  ObjectId id;
  std::uint8_t bits = 0;
  /// As a mapping parameter has it.
  [[nodiscard]] constexpr std::uint32_t word() const {
    return static_cast<std::uint32_t>(id.index) << 16 | static_cast<std::uint32_t>(id.sub) << 8 | bits;
  }
};
// The process data: to the drive, and from it. All of them are sent in each cycle, behind SYNC.
inline constexpr std::array<MappedObject, 3> kOutputs1{{{kControlWord, 16}, {kTargetPosition, 32}, {kMode, 8}}};
inline constexpr std::array<MappedObject, 1> kOutputs2{{{kVelocityOffset, 32}}};
inline constexpr std::array<MappedObject, 3> kInputs1{{{kStatusWord, 16}, {kPosition, 32}, {kModeDisplay, 8}}};
inline constexpr std::array<MappedObject, 2> kInputs2{{{kVelocity, 32}, {kTorque, 16}}};

/// Words for an error code of 603Fh and of emergency messages, of the row that fits best: "following error".
/// Realtime: setup.
[[nodiscard]] std::string_view text_of_error(std::uint16_t code);

// Error codes.
inline constexpr std::uint16_t kErrorHeartbeat = 0x8130, kErrorOutputsMissing = 0x8250, kErrorVelocity = 0x8400,
                               kErrorPosition = 0x8500, kErrorFollowing = 0x8611, kErrorSync = 0x8700,
                               kErrorPower = 0x3220;

}  // namespace takt::hw::cia402
