#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/planning/free_space.h"

namespace takt::planning {

/// What is looked for, and how hard. Paths are measured by joint speeds: the 2-norm of the times that the joints need.
struct Query {
  JointVector start;               ///< rad or m; free
  std::vector<JointVector> goals;  ///< at least one, all free: the path ends at one of them
  JointVector lower, upper;        ///< where postures are drawn, finite
  JointVector speed;               ///< of each joint, rad/s or m/s, > 0
  std::uint64_t seed = 1;
  std::int64_t looks = 100'000;  ///< postures that may be looked at until a first path is found
};

struct FoundPath {
  std::vector<JointVector> points;  ///< straight lines of the joints between them; start and goal included
  std::size_t goal = 0;             ///< the goal at which it ends
  double length = 0.0;              ///< s
};

/// The length of a straight line, s.
[[nodiscard]] double length_of(const JointVector& from, const JointVector& to, const JointVector& speed);
[[nodiscard]] double length_of(const std::vector<JointVector>& points, const JointVector& speed);

}  // namespace takt::planning
