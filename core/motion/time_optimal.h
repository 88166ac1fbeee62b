#pragma once

#include <optional>
#include <vector>

#include "core/motion/path_shape.h"
#include "core/motion/time_law.h"

namespace takt::motion {

/// How a path is entered that goes on with another motion: by this speed, first through `lead`, whatever the limits
/// say, then as fast as they allow.
struct MovingStart {
  TimeLaw::Begin begin;                ///< at s = 0
  std::vector<TimeLaw::Segment> lead;  ///< as the other motion's law goes on

  [[nodiscard]] LawPoint after_lead() const;
};

/// A law of constant s'' per piece, from rest to rest, before its jerk is bounded: piece i lasts from time[i] to
/// time[i + 1] and lies in cell[i] of the shape.
struct AccelerationLaw {
  std::vector<double> time;  ///< s, one more than pieces
  std::vector<double> dds;   ///< 1/s^2
  std::vector<double> s;     ///< where each piece begins, and 1
  std::vector<std::size_t> cell;

  [[nodiscard]] double duration() const { return time.back(); }
};

/// The fastest such law within velocity and acceleration limits; jerk is not looked at. Each cell of the shape is cut
/// into `cuts` pieces. `slow` (one entry per cell, >= 1) lowers the limits of a cell as if its time were stretched by
/// that much; empty: nowhere.
/// @return nothing if the shape stands still (no component moves) somewhere. Realtime: setup.
/// Source: Pham, Pham, "A new approach to time-optimal path parameterization based on reachability analysis", IEEE
/// T-RO 34(3), 2018; limits at both ends of a piece, discs for the length of a vector: own.
class ReachabilityPlanner {
 public:
  ReachabilityPlanner(const PathShape& shape, int cuts);
  [[nodiscard]] std::optional<AccelerationLaw> plan(const std::vector<double>& slow) const;
  /// The same from s with ds and dds on, which may be above the limits: then it brakes as hard as they say.
  [[nodiscard]] std::optional<AccelerationLaw> plan_from(const LawPoint& start, const std::vector<double>& slow) const;

 private:
  /// One limit on a piece in the plane of x = ds^2 at its begin and y = ds^2 at its end: m x - g <= y <= m x + g with
  /// g = sqrt(r^2 - (c x)^2); c = 0 for a joint.
  struct Row {
    double m, r, c;
  };
  struct Piece {
    double width;
    double s_begin;
    std::size_t cell;
    std::size_t first_row, last_row;
    double x_most, y_most;          ///< by the velocity limits
    double x_most_by_acceleration;  ///< by what leaves no choice of s'' at any higher speed
  };
  /// What y may be at some x, and how fast the ends move with x.
  struct Interval {
    double low, high, low_slope, high_slope;
  };

  void add_rows(const PathShape::Derivatives& d, const ShapeLimits& limits, bool at_end, Piece& piece);
  void add_row(double a, double b, double limit, Piece& piece);
  [[nodiscard]] Interval interval(const Piece& piece, double x, double scale) const;
  [[nodiscard]] static double scale_of(const Piece& piece, const std::vector<double>& slow);
  /// Goes on with a law through a piece, from ds^2 = x to ds^2 = y. @return false if it would stand in there
  [[nodiscard]] static bool append(AccelerationLaw& law, const Piece& piece, double x, double y);
  /// The largest ds^2 at the begin of each piece, and at the end, from which the end can be reached at rest. Empty if
  /// the shape stands still somewhere. Not looked at before `first`.
  [[nodiscard]] std::vector<double> reachable(const std::vector<double>& slow, std::size_t first) const;
  [[nodiscard]] double largest_begin(const Piece& piece, double x_most, double y_most, double scale) const;

  const PathShape& shape_;
  std::vector<Piece> pieces_;
  std::vector<Row> rows_;
};

/// The law averaged over a window in time: s'' becomes linear between knots, s still goes from 0 to 1.
[[nodiscard]] TimeLaw averaged(const AccelerationLaw& law, double window);
/// The same after a lead: `law` begins where mean_start() says, so that the mean joins the lead with equal s, ds, dds.
[[nodiscard]] TimeLaw averaged(const AccelerationLaw& law, double window, const MovingStart& start);
/// Where a law of constant s'' has to begin so that its mean over the window is at `at` then.
[[nodiscard]] LawPoint mean_start(const LawPoint& at, double window);

struct TimeOptimalOptions {
  int cuts = 2;     ///< pieces per cell
  int rounds = 20;  ///< at most, of slowing down where the average breaks a limit, per window
  /// Windows that are tried, as parts of the one that keeps the jerk at every jump of the acceleration.
  std::vector<double> windows = {1.0, 0.7, 0.5, 0.35};
};

/// A law near the time-optimal one under velocity, acceleration and jerk limits of the shape (what a law may use).
struct OptimalLaw {
  TimeLaw law;
  Loads loads;
};
/// @param shorter_than  s: nothing is looked for that cannot be shorter
/// @return nothing if there is no such law (see ReachabilityPlanner). Realtime: setup, deterministic.
[[nodiscard]] std::optional<OptimalLaw> time_optimal(const PathShape& shape, double shorter_than,
                                                     const TimeOptimalOptions& options = {});
/// A law that begins in motion. Its speeds cannot be stretched afterwards, so it has to keep what law and clock may
/// take together, whatever the law alone should take.
/// @param slow  one entry per cell, >= 1: limits there are lowered as if time were stretched by that much
/// @return nothing if no such law was found. Realtime: setup, deterministic.
[[nodiscard]] std::optional<OptimalLaw> time_optimal_in_motion(const PathShape& shape, const MovingStart& start,
                                                               const std::vector<double>& slow);

}  // namespace takt::motion
