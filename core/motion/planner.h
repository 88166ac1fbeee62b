#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/kinematics/chain.h"
#include "core/motion/clock_state.h"
#include "core/motion/limits.h"
#include "core/motion/path.h"
#include "core/motion/time_law.h"

namespace takt::kinematics {
class InverseKinematics;
}

namespace takt::motion {

/// What a piece of a path may do, seen from the limits.
struct PieceShares {
  double velocity = 1.0;                                             ///< shares as in MotionOptions
  double acceleration = 1.0;                                         ///< ...
  double linear_velocity = std::numeric_limits<double>::infinity();  ///< m/s

  bool operator==(const PieceShares&) const = default;
};

/// A planned motion: what moves (path), when (law), and how fast its path clock may change its rate so that every limit
/// holds for any history of targets in [-1, 1] (docs/motion.md). From rest, or going on with another motion: then the
/// law begins in motion.
struct Motion {
  Path path;
  TimeLaw law = {};
  ClockBounds clock = {};
  JointVector q_start = {};  ///< configuration at s = 0; rad or m
  JointVector q_goal = {};   ///< configuration at s = 1
  /// One entry per piece of the path: what a motion that goes on with this one keeps on the rest of it.
  std::vector<PieceShares> shares = {};

  [[nodiscard]] double duration() const { return law.duration(); }
};

/// What a motion may be asked for. Shares are of the limits given to the planner, in (0, 1].
struct MotionOptions {
  double velocity = 1.0;      ///< share of the velocity limits
  double acceleration = 1.0;  ///< share of the acceleration limits; the jerk limits scale alike
  /// LIN: speed of the frame on its line, m/s, > 0; bounds the motion in addition to the limits.
  std::optional<double> linear_velocity = std::nullopt;
  /// LIN: the frame that moves on the line, seen from the flange (a tool centre point).
  Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();
  /// What the motors move: then the motion keeps the torque limits of the chain, too.
  std::optional<DriveLoad> load = std::nullopt;
};

/// Plans a motion from rest to rest in which all joints go in proportion: as fast as the limits and the share kept for
/// the path clock allow. A goal equal to the start gives a motion of duration 0.
/// A base that cannot go sideways (`limits.nonholonomic`) turns on the spot, drives straight ahead or back, and turns
/// again, with a rest between.
/// @param q_start, q_goal  joint_count() entries
/// @return the motion, or diagnostics: wrong size, not finite, outside the range (joint, value, range) of start or
/// goal, bad limits or options, a load that a joint cannot carry on the way. Pointers: "/start/2", "/goal/2", "/goal",
/// "/options/velocity". Realtime: setup, deterministic.
[[nodiscard]] Result<Motion> plan_ptp(const kinematics::Chain& chain, const JointLimits& limits,
                                      const JointVector& q_start, const JointVector& q_goal,
                                      const MotionOptions& options = {});

/// Plans a straight line of the frame M = F * X_FM from where it is at q_start to X_BM_goal, on the branch of q_start.
/// @param held_goal  value of the held joints at the goal, in the order of the inverse kinematics; default: as at start
/// @return the motion, or diagnostics as for plan_ptp and: goal out of reach, joint range left on the way (joint,
/// value, range, path fraction), too near to a singularity (measure, path fraction), another branch. Realtime: setup,
/// deterministic.
[[nodiscard]] Result<Motion> plan_lin(const kinematics::Chain& chain, const kinematics::InverseKinematics& inverse,
                                      const JointLimits& limits, const CartesianLimits& cartesian_limits,
                                      const JointVector& q_start, const Eigen::Isometry3d& X_BM_goal,
                                      const std::optional<JointVector>& held_goal = {},
                                      const MotionOptions& options = {});

}  // namespace takt::motion
