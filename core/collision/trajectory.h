#pragma once

#include <functional>
#include <vector>

namespace takt::collision {

/// How joints move over time.
struct Trajectory {
  double duration = 0.0;         ///< s
  std::vector<int> joints = {};  ///< numbers of those that move
  /// Largest acceleration of each of them, rad/s^2 or m/s^2: how far a joint can leave the chord between two samples.
  std::vector<double> acceleration = {};
  /// Writes the largest acceleration of each of them between two times (s) into `most`, which has their number; null:
  /// `acceleration` says all that is known. Of long motions, which are slow somewhere.
  std::function<void(double from, double to, std::vector<double>& most)> acceleration_between = {};
  /// Writes the values of these joints at a time (s, in [0, duration]) into q, which is indexed by number of the joint.
  std::function<void(double time, std::vector<double>& q)> at;
};

}  // namespace takt::collision
