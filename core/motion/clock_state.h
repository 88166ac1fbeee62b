#pragma once

#include "core/motion/stop_table.h"

namespace takt::motion {

/// How fast the rate of path time may change. As JSON: {"acceleration_max": 1/s, "jerk_max": 1/s^2, "stop": a stop
/// table, left out if empty}.
struct ClockBounds {
  double acceleration_max = 1000.0;  ///< of the rate, 1/s: rest to full rate in a millisecond
  double jerk_max = 1e6;             ///< 1/s^2
  StopTable stop = {};               ///< what a stop may use where the arm is; empty: the two above
};

/// Where a path clock is: path time (s), its rate (1 = as planned), and the change of the rate (1/s).
struct ClockState {
  double tau = 0.0;
  double rate = 0.0;
  double rate_change = 0.0;
};

}  // namespace takt::motion
