#include "core/rcc/net_state.h"

#include <array>

namespace takt::rcc {

namespace {

constexpr std::array<std::string_view, 6> kNames = {"Loading", "Rejected",  "Ready",
                                                    "Running", "Canceling", "Terminated"};
using S = NetState;
struct Transition {
  S from, to;
};
constexpr std::array kTransitions = {
    Transition{S::kLoading, S::kReady},      Transition{S::kLoading, S::kRejected},
    Transition{S::kReady, S::kRunning},      Transition{S::kRunning, S::kCanceling},
    Transition{S::kRunning, S::kTerminated}, Transition{S::kCanceling, S::kTerminated},
};

}  // namespace

std::string_view name_of(NetState state) { return kNames[static_cast<std::size_t>(state)]; }

bool is_legal(NetState from, NetState to) {
  for (const Transition& transition : kTransitions)
    if (transition.from == from && transition.to == to) return true;
  return false;
}

}  // namespace takt::rcc
