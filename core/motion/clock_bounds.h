#pragma once

#include <array>

#include <Eigen/Core>

#include "core/motion/path_clock.h"

namespace takt::motion {

/// Finds the fastest clock that keeps every limit for any history of targets in [-1, 1] (docs/motion.md, "What the
/// clock may do"). Fed with the plan's derivatives by path time at enough instants.
///
/// A bounded quantity f has, under a clock with rate r: f'' = f_tt r^2 + f_t r' and
/// f''' = f_ttt r^3 + 3 f_tt r r' + f_t r''. Since r never leaves [-1, 1] and |r''| <= J, a rate change r' is only met
/// where |r| <= 1 - r'^2 / (2 J); the search uses that, so a law may keep most of the limits to itself. Realtime:
/// setup.
class ClockSearch {
 public:
  ClockSearch();

  /// One bounded quantity at one instant of the plan: absolute derivatives by path time, each over the limit of its
  /// order as it stands in f'' <= a (first, second) and f''' <= j (first, second, third).
  struct Load {
    double first_by_acceleration;   ///< |f_t| / a, s
    double second_by_acceleration;  ///< |f_tt| / a
    double first_by_jerk;           ///< |f_t| / j, s^2
    double second_by_jerk;          ///< |f_tt| / j, s
    double third_by_jerk;           ///< |f_ttt| / j
  };
  void add(const Load& load);

  [[nodiscard]] ClockBounds bounds() const;

 private:
  static constexpr int kShapes = 3;
  static constexpr int kRates = 12;
  /// A clock = (shape k, pace w): acceleration_max = k w, jerk_max = w^2. Then |r'| <= w min(k, sqrt(2 (1 - |r|))), and
  /// each limit gives one largest w per shape.
  struct Shape {
    using Rates = Eigen::Array<double, kRates, 1>;
    double k;
    double pace;   ///< largest w so far
    Rates change;  ///< |r'| / w at which ...
    Rates rate;    ///< ... the largest rate is this
    Rates rate_change, rate_squared, rate_cubed;

    /// False if at each rate law and clock stay below the limit by more than rounding.
    [[nodiscard]] bool may_break(const Load& load) const;
  };
  std::array<Shape, kShapes> shapes_;
  /// The largest over the shapes of k w and of w: a load that they allow is allowed by each.
  double most_change_ = 0.0, most_pace_ = 0.0;
  void note_most();
};

}  // namespace takt::motion
