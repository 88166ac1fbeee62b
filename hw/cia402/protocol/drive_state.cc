#include "hw/cia402/protocol/drive_state.h"

#include <array>

namespace takt::hw::cia402 {
namespace {

using State = DriveState;

/// A state, its bits in the status word, and which of them count.
struct StateBits {
  State state;
  std::uint16_t mask, bits;
  std::string_view name;
};
constexpr std::array<StateBits, 8> kStates{{
    {State::kNotReadyToSwitchOn, 0x4F, 0x00, "not ready to switch on"},
    {State::kSwitchOnDisabled, 0x4F, 0x40, "switch on disabled"},
    {State::kReadyToSwitchOn, 0x6F, 0x21, "ready to switch on"},
    {State::kSwitchedOn, 0x6F, 0x23, "switched on"},
    {State::kOperationEnabled, 0x6F, 0x27, "operation enabled"},
    {State::kQuickStopActive, 0x6F, 0x07, "quick stop active"},
    {State::kFaultReactionActive, 0x4F, 0x0F, "fault reaction active"},
    {State::kFault, 0x4F, 0x08, "fault"},
}};

/// A command of the control word: its bits, and which of them count.
struct Command {
  std::uint16_t mask, bits;
  [[nodiscard]] bool given(std::uint16_t control) const { return (control & mask) == bits; }
};
constexpr Command kCommandVoltageOff{0x02, 0x00}, kCommandQuickStop{0x06, 0x02}, kCommandShutdown{0x87, 0x06},
    kCommandSwitchOn{0x8F, 0x07}, kCommandEnable{0x8F, 0x0F};

/// A transition by a command, with its number in the standard. Commands exclude each other.
struct Transition {
  State from;
  Command command;
  State to;
};
constexpr Transition kTransitions[] = {
    {State::kSwitchOnDisabled, kCommandShutdown, State::kReadyToSwitchOn},     // 2
    {State::kReadyToSwitchOn, kCommandVoltageOff, State::kSwitchOnDisabled},   // 7
    {State::kReadyToSwitchOn, kCommandQuickStop, State::kSwitchOnDisabled},    // 7
    {State::kReadyToSwitchOn, kCommandSwitchOn, State::kSwitchedOn},           // 3
    {State::kReadyToSwitchOn, kCommandEnable, State::kSwitchedOn},             // 3, on the way to 4
    {State::kSwitchedOn, kCommandVoltageOff, State::kSwitchOnDisabled},        // 10
    {State::kSwitchedOn, kCommandQuickStop, State::kSwitchOnDisabled},         // 10
    {State::kSwitchedOn, kCommandShutdown, State::kReadyToSwitchOn},           // 6
    {State::kSwitchedOn, kCommandEnable, State::kOperationEnabled},            // 4
    {State::kOperationEnabled, kCommandVoltageOff, State::kSwitchOnDisabled},  // 9
    {State::kOperationEnabled, kCommandQuickStop, State::kQuickStopActive},    // 11
    {State::kOperationEnabled, kCommandShutdown, State::kReadyToSwitchOn},     // 8
    {State::kOperationEnabled, kCommandSwitchOn, State::kSwitchedOn},          // 5
    {State::kQuickStopActive, kCommandVoltageOff, State::kSwitchOnDisabled},   // 12
};

}  // namespace

std::string_view name_of(DriveState state) { return kStates[static_cast<std::size_t>(state)].name; }

DriveState state_of(std::uint16_t status) {
  for (const StateBits& row : kStates)
    if ((status & row.mask) == row.bits) return row.state;
  return State::kNotReadyToSwitchOn;
}

/// Bit 5 says "no quick stop": where the state leaves it open it is set.
std::uint16_t status_of(DriveState state) {
  constexpr std::uint16_t kNoQuickStop = 0x20;
  const StateBits& row = kStates[static_cast<std::size_t>(state)];
  const bool open = (row.mask & kNoQuickStop) == 0 && state != State::kNotReadyToSwitchOn;
  return open ? static_cast<std::uint16_t>(row.bits | kNoQuickStop) : row.bits;
}

DriveState next_state(DriveState state, std::uint16_t control, std::uint16_t before) {
  const bool reset = (control & kFaultReset) != 0 && (before & kFaultReset) == 0;
  if (state == State::kFault) return reset ? State::kSwitchOnDisabled : State::kFault;  // 15
  for (const Transition& row : kTransitions)
    if (row.from == state && row.command.given(control)) return row.to;
  return state;
}

std::uint16_t control_for(Wanted wanted, DriveState state) {
  if (wanted == Wanted::kOff) return kDisableVoltage;
  const bool moves = state == State::kOperationEnabled || state == State::kQuickStopActive;
  if (wanted == Wanted::kQuickStop) return moves ? kQuickStopWord : kDisableVoltage;
  switch (state) {
    case State::kSwitchOnDisabled:
      return kShutdown;
    case State::kReadyToSwitchOn:
      return kSwitchOn;
    case State::kSwitchedOn:
    case State::kOperationEnabled:
      return kEnableOperation;
    default:
      return kDisableVoltage;
  }
}

}  // namespace takt::hw::cia402
