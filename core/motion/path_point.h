#pragma once

namespace takt::motion {

/// Path parameter and its derivatives with respect to real time: what a path is sampled with.
struct PathPoint {
  double s = 0.0;
  double ds = 0.0;   ///< 1/s
  double dds = 0.0;  ///< 1/s^2
};

}  // namespace takt::motion
