#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/motion/clock_state.h"
#include "core/motion/time_law.h"

namespace takt::motion {

/// Brings a path clock to rest as hard as the limits allow where the arm is (docs/motion.md, "Stops"): s is braked as
/// hard as a stop table allows in the cell in which it is, as long as from the next cycle on there is a stop within
/// constant bounds that keeps the limits of every cell it crosses. Path time and rate follow from s by the law. The
/// rate never rises meanwhile, so no limit is met that the law does not keep. A clock that runs backwards is left to
/// its own bounds.
///
/// One for each path clock. Copyable: a copy continues bit for bit as the original.
class Braking {
 public:
  /// @param table  not empty   Realtime: setup.
  Braking(TimeLaw law, StopTable table);

  /// Advances the clock by one period (s) if this is a stop of its own: the target is 0 and a stop by the table is
  /// shorter than by the bounds of the clock, or such a stop is under way. After a new target it eases the stop until
  /// the clock's bounds hold again. @param lowest  rate that the clock may have   @return false: nothing was changed
  /// Realtime: cyclic, no allocation; O(cells that the stop crosses).
  bool advance(ClockState& clock, double target, double period, const ClockBounds& bounds, double lowest);

 private:
  /// Bounds of a whole stop: of the deceleration of s, 1/s^2, and of its third derivative, 1/s^3.
  struct Bounds {
    double deceleration, jerk;
  };
  struct Piece {
    double time, jerk;
  };
  /// Of s: way done, velocity and its derivative.
  struct Motion {
    double way, velocity, acceleration;
    void go(const Piece& piece, double time);
  };
  struct Profile;
  struct Course;
  /// A stop that keeps the limits: its bounds, and how far and how long it goes on.
  struct Found {
    Bounds bounds;
    double way, time;
  };
  struct Plan {
    TimeLaw law;
    StopTable table;
    std::vector<double> slowest;  ///< of each cell: least s' of the law in it, 1/s
  };
  /// A cycle, and what bounds the rate in it.
  struct Step {
    double fastest, jerk_max, period;
  };

  [[nodiscard]] static std::optional<Profile> to_rest(const Motion& now, const Bounds& bounds);
  [[nodiscard]] std::size_t cell_at(double s) const;
  /// The shortest stop of a few from s on, at this rate at most.
  [[nodiscard]] std::optional<Found> stop_from(double s, double rate, const Motion& now) const;
  /// The same with at most this deceleration. Nothing: a limit does not allow it.
  [[nodiscard]] std::optional<Found> stop_within(double deceleration, double s, double rate, const Motion& now) const;
  /// Lowers the bounds to what the cells allow that a stop with them crosses. @return false: one allows none.
  [[nodiscard]] bool lower(double s, double rate, const Motion& now, Bounds& bounds) const;
  /// A harder cycle, if a stop follows it and both together are shorter than `stop`. @param[in,out] now  where it leads
  [[nodiscard]] std::optional<Bounds> harder_cycle(double s, const Step& step, const Profile& stop, Motion& now) const;
  [[nodiscard]] double strongest_jerk(double s, const Step& step, const Motion& now) const;
  [[nodiscard]] bool begins(const ClockState& clock, const LawPoint& at, const Profile& stop,
                            const ClockBounds& bounds) const;
  /// Takes the clock to s, or makes its rate steady where it would rise.
  bool move(ClockState& clock, double s, const Motion& then, const Step& step);
  /// Path time within one period from now at which s is `s`; nothing: the rate `fastest` does not get there.
  [[nodiscard]] std::optional<double> time_of(double s, const ClockState& clock, double fastest, double period) const;
  static void follow(const Profile& stop, double period, Motion& now);
  bool leave();

  std::shared_ptr<const Plan> plan_;
  std::optional<Bounds> held_;  ///< of the stop that is under way
};

}  // namespace takt::motion
