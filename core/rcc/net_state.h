#pragma once

#include <cstdint>
#include <string_view>

namespace takt::rcc {

/// A net in the control core, by number; 0 is no net. Numbers are never used twice.
using NetId = std::uint32_t;

/// The life cycle of a net (row L1).
enum class NetState : std::uint8_t { kLoading, kRejected, kReady, kRunning, kCanceling, kTerminated };

[[nodiscard]] std::string_view name_of(NetState state);

/// True if a net may go from one state to the other; staying is no transition.
///   Loading -> Ready | Rejected;  Ready -> Running;  Running -> Canceling | Terminated;  Canceling -> Terminated
[[nodiscard]] bool is_legal(NetState from, NetState to);

/// True while the net is evaluated each cycle and holds its devices.
[[nodiscard]] constexpr bool is_active(NetState state) {
  return state == NetState::kRunning || state == NetState::kCanceling;
}

}  // namespace takt::rcc
