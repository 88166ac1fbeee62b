#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/command/mapping.h"
#include "core/net/compiled_net.h"

namespace takt::activity {

/// What an event did to a motion: as it was measured, beside what LOAD certified for the net (rows O6, O7).
struct Reaction {
  std::string activity;           ///< its name
  std::string event;              ///< location of its handler in the command, for people
  std::int64_t event_cycle = -1;  ///< of the core, in which the event was there first; -1: it never was
  std::int64_t braking_cycle =
      -1;  ///< of the first set point that brakes; -1: none, or the clock's rate was not steady
  std::int64_t least = 0, most = 0;  ///< certified cycles from a sensor of the event to the set point
};

/// Measures the reactions of one net that runs. Owned by its run; the net outlives it. Thread: the program's, between
/// cycles. Realtime: setup.
class ReactionWatch {
 public:
  void attach(const std::string& activity, const net::CompiledNet& net, const std::vector<command::BrakePorts>& brakes);
  /// After a cycle in which the net was evaluated. @param cycle  that one
  void look(std::int64_t cycle);
  /// Only of events that come from sensors.
  [[nodiscard]] const std::vector<Reaction>& reactions() const { return reactions_; }

 private:
  /// The ports of an event and of the clock of the motion that it cancels, and how the clock was a cycle ago.
  struct Watched {
    const net::Slot<net::Boolean>* event = nullptr;
    const net::Slot<net::Real>*rate = nullptr, *derivative = nullptr;
    double rate_before = 0.0;
    bool steady_before = false;
    bool compared = false;  ///< the clock ran steadily when the event came, so its first fall is the brake
  };
  static void look(std::int64_t cycle, Watched& watched, Reaction& reaction);

  std::vector<Reaction> reactions_;
  std::vector<Watched> watched_;  ///< one for each reaction
};

}  // namespace takt::activity
