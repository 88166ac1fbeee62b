#pragma once

namespace takt::motion::test {

/// Limits of one axis.
struct AxisLimits {
  double velocity, acceleration, jerk;
};

/// Shortest time from rest at 0 to rest at `way`, by an independent generator (Ruckig). Fails the running test if that
/// has no answer.
[[nodiscard]] double shortest_time(const AxisLimits& limits, double way);

/// Shortest time from a velocity and acceleration to `target_velocity` at acceleration 0.
[[nodiscard]] double shortest_time_to_velocity(const AxisLimits& limits, double velocity, double acceleration,
                                               double target_velocity);

}  // namespace takt::motion::test
