#pragma once

#include <vector>

#include "core/kinematics/inverse.h"
#include "core/motion/path.h"

namespace takt::motion {

/// Why a walk along a line ended.
enum class WalkEnd {
  kGoal,         ///< the whole line can be followed
  kUnreachable,  ///< no solution any more on the branch of the start
  kSingular,     ///< the singularity measure fell below kSingularityLeast
  kOtherBranch   ///< the next solution is not the continuation of the last
};

/// Joint path of a Cartesian line: inverse kinematics at equally spaced s, with exact first and second derivatives by
/// s; in between, cubic Hermite interpolation of the first derivative.
struct LineWalk {
  struct Node {
    JointVector q;
    JointVector dq;   ///< by s
    JointVector ddq;  ///< by s, twice
  };
  /// First to third derivative of q by s.
  struct Derivatives {
    JointVector first;
    JointVector second;
    JointVector third;
  };

  std::vector<Node> nodes;  ///< at s = 0, 1/steps, 2/steps ... as far as the walk came
  int steps = 0;
  WalkEnd end = WalkEnd::kGoal;
  double s_end = 1.0;    ///< where it ended
  double measure = 0.0;  ///< of the singularity, at s_end

  [[nodiscard]] double s(std::size_t node) const { return static_cast<double>(node) / steps; }
  /// For complete walks only; s in [0, 1].
  [[nodiscard]] Derivatives derivatives(double s) const;
  /// By how much the third derivative of the interpolation jumps at a node, largest over all nodes, per joint: an
  /// estimate (from above, by half) of how far it is off.
  [[nodiscard]] JointVector roughness() const;
};

/// Below this measure (InverseKinematics::singularity_measure) joint rates grow beyond any use.
inline constexpr double kSingularityLeast = 0.01;

/// Walks along the line of frame M = F * X_FM from q_start. Realtime: setup.
[[nodiscard]] LineWalk walk_line(const kinematics::InverseKinematics& inverse, const CartesianLine& line,
                                 const Eigen::Isometry3d& X_FM, const JointVector& q_start, int steps);

}  // namespace takt::motion
