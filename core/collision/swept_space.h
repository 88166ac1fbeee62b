#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/collision/motion_check.h"

/// Where bodies are during motions, whenever that is (docs/planning.md, "Beside machines that move").
namespace takt::collision {

/// A body at one of the poses of its motion.
struct SweptPose {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  double within = 0.0;  ///< m: until the poses before and behind it no point is further from where it has it
  double time = 0.0;    ///< s, of the motion; NaN: not known
  int source = 0;       ///< index in SweptSpace::sources
};

/// What bodies sweep: at any time of the motions each of their points is within `within` of where one pose has it.
struct SweptSpace {
  /// By number of the body. One without poses moves, but what it sweeps does not count.
  std::map<int, std::vector<SweptPose>> bodies = {};
  std::vector<std::string> sources = {};  ///< names of motions, for people

  /// Number of a source with this name; it is added where there is none.
  [[nodiscard]] int source(const std::string& name);
};

/// From where a motion is seen: as if this body stood at X_WB and all else moved about it.
struct Viewpoint {
  int body = -1;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
};

/// Adds what these bodies sweep during a motion. One that stands still gets one pose.
/// @param spacing  m, > 0: poses are so dense that no point travels further from one to the next, as far as the samples
/// of the motion allow (4 ms)   @param begin  s: `time` of the first poses; NaN: not known
/// @param source  of the poses   @param view  from where it is seen; null: from the world. Realtime: setup,
/// deterministic.
void add_swept(const Scene& scene, const State& state, const Trajectory& motion, std::span<const int> bodies,
               double spacing, double begin, int source, SweptSpace& swept, const Viewpoint* view = nullptr);

/// The same poses, to the last bit.
[[nodiscard]] bool same_space(const SweptSpace& a, const SweptSpace& b);

}  // namespace takt::collision
