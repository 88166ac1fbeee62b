#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/motion/braking.h"
#include "core/motion/clock_state.h"
#include "core/motion/path_point.h"
#include "core/motion/time_law.h"

namespace takt::motion {

/// The bounds that suit both of two motions on one clock.
[[nodiscard]] ClockBounds common(const ClockBounds& a, const ClockBounds& b);

/// The law under the clock: s' = s_tau r, s'' = s_tautau r^2 + s_tau r'. Realtime: cyclic.
[[nodiscard]] PathPoint follow(const TimeLaw& law, const ClockState& clock);

/// The path clock (rows P1, P2): path time advances with a rate that follows its target in the shortest time within
/// bounds on its first and second derivative, without overshoot. Cancel and pause are target 0, override a target
/// between 0 and 1, backwards a negative one.
///
/// - Allowed rates: [0, 1], with `retraceable` [-1, 1]. Targets outside are brought to the nearest, NaN counts as 0.
/// - tau stays in [0, duration] and ends on exactly these values. A planned law is at rest there, so the rate is free
///   to jump: it starts at its target at once when it leaves an end, and becomes 0 when it arrives.
/// - A reached target is held exactly (rate == target, rate_change == 0) until it changes.
/// - Under target 0 it stops as hard as the bounds' stop table allows where the arm is, if it knows the law and that is
///   shorter; a new target ends such a stop as soon as the two bounds hold again.
/// - `in_motion`: the law does not begin at rest, so nothing is free to jump there. The clock begins at rate 1, or with
///   the state of the clock that it takes over (reset()), and does not run back.
///
/// Owned by one net, called once a cycle. Copyable: a copy continues bit for bit as the original.
class PathClock {
 public:
  /// Stands at tau = 0. Bounds > 0, duration >= 0 (s), finite. Realtime: setup.
  PathClock(const ClockBounds& bounds, double duration, bool retraceable, bool in_motion = false);
  /// Of a motion with this law, which the stop table of the bounds belongs to. Realtime: setup.
  PathClock(const ClockBounds& bounds, const TimeLaw& law, bool retraceable, bool in_motion = false);

  /// Advances by one period (s, >= 0) towards the target. Within the period the exact profile is followed, so the
  /// bounds hold between the cycles too. Realtime: cyclic, no allocation, bitwise repeatable; closed form but for stops
  /// by the table.
  const ClockState& update(double target_rate, double period);

  /// Takes another state over, inside the allowed ranges: a hand-over in motion, or a jump while at rest.
  void reset(const ClockState& state);

  [[nodiscard]] const ClockState& state() const { return state_; }
  [[nodiscard]] double duration() const { return duration_; }
  [[nodiscard]] bool at_start() const { return state_.tau <= 0.0; }
  [[nodiscard]] bool at_end() const { return state_.tau >= duration_; }
  [[nodiscard]] bool at_rest() const { return state_.rate == 0.0 && state_.rate_change == 0.0; }
  /// Longest time (s) from any state to rest under target 0 (row L6).
  [[nodiscard]] double stop_time_bound() const;

 private:
  void follow_target(double target, double period);
  void advance(double rate_jerk, double time);
  /// True if it is at an end of the path that the target does not leave; an end that it leaves has been left.
  bool stays(double target);

  ClockBounds bounds_;  ///< without the stop table
  std::optional<Braking> braking_;
  double duration_;
  double lowest_;  ///< allowed rates: [lowest_, 1]
  bool in_motion_;
  ClockState state_;
};

[[nodiscard]] nlohmann::ordered_json to_json(const ClockBounds& bounds);
[[nodiscard]] Result<ClockBounds> clock_bounds_from_json(const nlohmann::ordered_json& json,
                                                         const std::string& pointer = {});

}  // namespace takt::motion
