#pragma once

namespace takt::motion {

/// Where one axis comes on its way to rest.
struct StopRange {
  double lowest = 0.0, highest = 0.0;  ///< the state itself included
};

/// The positions that an axis at q, dq, ddq passes if it brakes to rest in the shortest time within |ddq| <=
/// acceleration and jerk (both > 0, |ddq| <= acceleration now). Realtime: cyclic, closed form.
[[nodiscard]] StopRange stop_range(double q, double dq, double ddq, double acceleration, double jerk);

}  // namespace takt::motion
