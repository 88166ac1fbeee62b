#include "core/activity/run_state.h"

#include <algorithm>

namespace takt::activity {
namespace {

using enum RunState;

constexpr std::array kTransitions = {
    RunTransition{kQueued, RunEvent::kPlanned, kLoaded},
    RunTransition{kQueued, RunEvent::kCancelled, RunState::kCancelled},
    RunTransition{kQueued, RunEvent::kFailed, RunState::kFailed},
    RunTransition{kLoaded, RunEvent::kSwitchAsked, kSwitching},
    RunTransition{kLoaded, RunEvent::kBegan, kRunning},
    RunTransition{kLoaded, RunEvent::kReturnAsked, kReturning},
    RunTransition{kLoaded, RunEvent::kCancelled, RunState::kCancelled},
    RunTransition{kLoaded, RunEvent::kFailed, RunState::kFailed},
    RunTransition{kSwitching, RunEvent::kSwitched, kLoaded},
    RunTransition{kSwitching, RunEvent::kReturnAsked, kReturning},
    RunTransition{kSwitching, RunEvent::kCancelled, RunState::kCancelled},
    RunTransition{kSwitching, RunEvent::kFailed, RunState::kFailed},
    RunTransition{kRunning, RunEvent::kReturnAsked, kReturning},
    RunTransition{kRunning, RunEvent::kEnded, kCompleted},
    RunTransition{kRunning, RunEvent::kCancelled, RunState::kCancelled},
    RunTransition{kRunning, RunEvent::kFailed, RunState::kFailed},
    RunTransition{kReturning, RunEvent::kEnded, kCompleted},
    RunTransition{kReturning, RunEvent::kCancelled, RunState::kCancelled},
    RunTransition{kReturning, RunEvent::kFailed, RunState::kFailed},
};

}  // namespace

std::string_view name_of(RunState state) {
  static constexpr std::array<std::string_view, 8> kNames = {"queued",    "loaded",    "switching", "running",
                                                             "returning", "completed", "cancelled", "failed"};
  return kNames.at(static_cast<std::size_t>(state));
}

std::string_view name_of(RunEvent event) {
  static constexpr std::array<std::string_view, 8> kNames = {"planned",      "switch asked", "switched",  "began",
                                                             "return asked", "ended",        "cancelled", "failed"};
  return kNames.at(static_cast<std::size_t>(event));
}

std::span<const RunTransition> run_transitions() { return kTransitions; }

std::optional<RunState> next_state(RunState state, RunEvent event) {
  const auto row = std::ranges::find_if(
      kTransitions, [&](const RunTransition& one) { return one.from == state && one.event == event; });
  return row == kTransitions.end() ? std::nullopt : std::optional(row->to);
}

}  // namespace takt::activity
