#pragma once

#include <vector>

#include "core/kinematics/inverse.h"
#include "core/motion/path.h"

namespace takt::motion {

/// Why a walk along a piece of a path ended.
enum class WalkEnd {
  kGoal,         ///< the whole piece can be followed
  kUnreachable,  ///< no solution any more on the branch of the start
  kSingular,     ///< the singularity measure fell below kSingularityLeast
  kOtherBranch   ///< the next solution is not the continuation of the last
};

/// A piece of a path seen in joints (and in the frame, where it is Cartesian) at equally spaced places, with exact
/// first and second derivatives. t in [0, 1] runs over the piece, from own_begin to own_end of its geometry.
struct PieceWalk {
  struct Node {
    JointVector q;
    JointVector dq;                 ///< by t
    JointVector ddq;                ///< by t, twice
    Vector6 dX = Vector6::Zero();   ///< motion of M by t, linear first; zero on joint pieces
    Vector6 ddX = Vector6::Zero();  ///< its derivative by t
  };

  std::vector<Node> nodes;  ///< at t = 0, 1/steps, 2/steps ... as far as the walk came
  int steps = 0;
  WalkEnd end = WalkEnd::kGoal;
  double t_end = 1.0;    ///< where it ended
  double measure = 0.0;  ///< of the singularity that ended it, at its last node

  [[nodiscard]] double t(std::size_t node) const { return static_cast<double>(node) / steps; }
  /// The third derivative by t is interpolated from the nodes. By how much it jumps at a node, largest over all nodes,
  /// per joint: an estimate (from above, by half) of how far it is off. For complete walks only.
  [[nodiscard]] JointVector roughness() const;
};

/// Below this measure (InverseKinematics::singularity_measure) joint rates grow beyond any use.
inline constexpr double kSingularityLeast = 0.01;

/// Walks along a piece in `steps` steps. On a Cartesian piece of frame M = F * X_FM inverse kinematics follows from
/// q_start; on a joint piece q_start and `inverse` are not looked at. Realtime: setup.
[[nodiscard]] PieceWalk walk_piece(const kinematics::InverseKinematics* inverse, const PathPiece& piece,
                                   const Eigen::Isometry3d& X_FM, const JointVector& q_start, int steps);

}  // namespace takt::motion
