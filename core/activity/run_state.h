#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace takt::activity {

/// How far one execution of an activity is. The order is that of its life.
enum class RunState : std::uint8_t {
  kQueued,     ///< waits for others that have its actuators, or until it is known where they will be
  kLoaded,     ///< planned, its net is loaded; it starts when its predecessors end, or are left
  kSwitching,  ///< its arms go into the control modes that its net needs
  kRunning,    ///< its net is evaluated in each cycle; of an activity without a net: its arm changes its control mode
  kReturning,  ///< it has ended, and its arms go back into the control modes of before
  kCompleted,  ///< it came to its end, or another one went on with it
  kCancelled,  ///< it came to rest because it was asked to
  kFailed      ///< diagnostics() says why
};
[[nodiscard]] std::string_view name_of(RunState state);
/// It is over, one way or another.
[[nodiscard]] constexpr bool is_final(RunState state) { return state >= RunState::kCompleted; }
/// It has not begun, and could be given up.
[[nodiscard]] constexpr bool is_waiting(RunState state) {
  return state == RunState::kQueued || state == RunState::kLoaded;
}

/// What the scheduler sees between two cycles that moves an execution on.
enum class RunEvent : std::uint8_t {
  kPlanned,      ///< it is planned, and its net, if it has one, was accepted by LOAD
  kSwitchAsked,  ///< it is its turn, and its arms were asked to change their control modes
  kSwitched,     ///< they are in these modes
  kBegan,        ///< its net was evaluated; without a net: the change of modes was asked for
  kReturnAsked,  ///< it has ended, however, and its arms have to go back into their former modes
  kEnded,        ///< the end in order
  kCancelled,    ///< the end that was asked for, before or after it began
  kFailed        ///< not planned, rejected, not started, stopped, given up with its predecessor, or a mode was refused
};
[[nodiscard]] std::string_view name_of(RunEvent event);

/// What made an execution fail; diagnostics() of the run say it in words.
enum class RunFailure : std::uint8_t {
  kNone,
  kImpossible,   ///< it could not be planned, or LOAD has rejected its net
  kFault,        ///< an arm that it needs has a fault
  kRefused,      ///< the core has refused to start it
  kModeRefused,  ///< the core, or a device, has refused to change a control mode
  kStopped,      ///< its net has ended by a failure
  kAborted,      ///< what must not hold did (`abort_if`), or was unknown: its arms are at rest
  kGivenUp       ///< what it waited for was cancelled, or has failed
};

/// A row of the table by which the scheduler works (docs/activity-layer.md shows the same rows).
struct RunTransition {
  RunState from;
  RunEvent event;
  RunState to;
};
/// All that can happen; what is not in it is a programming error. A test compares it with the page.
[[nodiscard]] std::span<const RunTransition> run_transitions();
/// @return nothing: this cannot happen in this state
[[nodiscard]] std::optional<RunState> next_state(RunState state, RunEvent event);

}  // namespace takt::activity
