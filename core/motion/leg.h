#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/motion/planner.h"

namespace takt::motion {

/// What planning needs to know of an arm. Refers to its parts: they outlive it.
struct ArmModel {
  const kinematics::Chain& chain;
  const kinematics::InverseKinematics* inverse;  ///< null: joint motions only
  const JointLimits& limits;
  const CartesianLimits& cartesian;
  Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();  ///< the frame that Cartesian motions move, in the flange
  std::optional<DriveLoad> load = std::nullopt;            ///< nothing: torques are not looked at

  [[nodiscard]] const DriveLoad* drive_load() const { return load ? &*load : nullptr; }
};

/// How far before its goal a motion may be left for the next one, and after its start the next one is joined.
struct Blend {
  enum class Kind { kNone, kDistance, kFraction };
  Kind kind = Kind::kNone;
  double value = 0.0;  ///< m of the way of M as the crow flies, or share of each motion, (0, 0.5]
};

/// Geometry of one motion: pieces over [0, 1], and what it may do.
struct Leg {
  std::vector<PathPiece> pieces;
  double velocity = 1.0;      ///< shares as in MotionOptions
  double acceleration = 1.0;  ///< ...
  std::optional<double> linear_velocity;
  Blend blend;  ///< into the motion after it
};

/// How M turns on an arc.
enum class ArcOrientation {
  kFixed,      ///< not at all
  kToGoal,     ///< evenly, the short way, to the orientation of the goal
  kTangential  ///< with the tangent: the same side of M shows to the centre all the time
};

/// Circle through a start, a point on the way and a goal, all of M in B.
struct ArcThrough {
  Eigen::Vector3d p_via = Eigen::Vector3d::Zero();
  Eigen::Isometry3d X_BM_goal = Eigen::Isometry3d::Identity();
  ArcOrientation orientation = ArcOrientation::kToGoal;
};
/// Circle about an axis in B, by an angle of either sign; not with kToGoal.
struct ArcAbout {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double angle = 0.0;  ///< rad; more than a turn is allowed
  ArcOrientation orientation = ArcOrientation::kFixed;
};

// Geometry from where the arm is. Held joints stay as they are. All: realtime: setup; diagnostics at "/goal", "/via",
// "/centre", "/axis", "/points/2".

[[nodiscard]] Result<Leg> ptp_leg(const ArmModel& arm, const JointVector& q_start, const JointVector& q_goal);
[[nodiscard]] Result<Leg> lin_leg(const ArmModel& arm, const JointVector& q_start, const Eigen::Isometry3d& X_BM_goal);
[[nodiscard]] Result<Leg> circ_leg(const ArmModel& arm, const JointVector& q_start, const ArcThrough& arc);
[[nodiscard]] Result<Leg> circ_leg(const ArmModel& arm, const JointVector& q_start, const ArcAbout& arc);
/// Through all points, the last one the goal.
[[nodiscard]] Result<Leg> spline_leg(const ArmModel& arm, const JointVector& q_start,
                                     const std::vector<JointVector>& points);
[[nodiscard]] Result<Leg> spline_leg(const ArmModel& arm, const JointVector& q_start,
                                     const std::vector<Eigen::Isometry3d>& poses_BM);

/// Makes the geometry of a motion once it is known where the one before ends.
using LegMaker = std::function<Result<Leg>(const JointVector& q_start)>;

/// A sequence of motions as one planned motion.
struct SequencePlan {
  Motion motion;
  /// Notes: where a blend was made smaller, and where the arm stops although a blend was asked for, with the reason.
  /// Pointers "/1/blend" (index of the motion).
  Diagnostics notes;
  /// Path time (s) at which each motion but the last hands over: in the middle of its blend, or at its goal.
  std::vector<double> handed_over;
};

/// Plans motions one after the other as one path with one time law: through blends without stopping, with a rest where
/// there is none. A blend that cannot be made becomes a rest, with a note.
/// @return the plan, or diagnostics "/1/goal" (index of the motion) of its geometry, reach, ranges, branch. Realtime:
/// setup, deterministic.
[[nodiscard]] Result<SequencePlan> plan_sequence(const ArmModel& arm, const JointVector& q_start,
                                                 const std::vector<LegMaker>& makers);

/// A motion that is left for another one while it runs.
struct Departure {
  const Motion& motion;
  double tau = 0.0;     ///< path time at which the other one takes over, s
  double lead = 0.0;    ///< so long the other one goes on exactly as the motion would, s
  Blend blend;          ///< how far before its goal the motion is left
  double shrink = 1.0;  ///< share of the blend that is tried first
};

/// Plans motions that go on with one that is running, from `tau` on: what is left of it, a blend, then the others. At
/// tau the plan has position, velocity and acceleration of the motion, and until tau + lead every bit of its time law,
/// so it may take over anywhere between. If the blend does not fit, since the motion is too far on or too fast, smaller
/// ones are tried.
/// @return the plan, or why it has to wait for the end of the motion: diagnostics "/blend", "/tau", or as
/// plan_sequence(). Realtime: setup, deterministic.
[[nodiscard]] Result<SequencePlan> plan_take_over(const ArmModel& arm, const Departure& from,
                                                  const std::vector<LegMaker>& makers);

}  // namespace takt::motion
