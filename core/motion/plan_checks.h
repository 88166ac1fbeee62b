#pragma once

#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/kinematics/chain.h"
#include "core/motion/planner.h"

namespace takt::motion {

/// Shares of the acceleration and jerk limits that a law may use; the path clock gets the rest. A law slowed down by
/// k = 1.126 (1 / cube root of 0.7) needs only 1/k^2 = 0.79 and 1/k^3 = 0.7 of them: the shares cost at most an eighth
/// of the shortest time. docs/motion.md compares others.
inline constexpr double kLawShareOfAcceleration = 0.8;
inline constexpr double kLawShareOfJerk = 0.7;
/// Of the velocity limits only rounding and the interpolation between instants get a part: no clock runs above rate 1.
inline constexpr double kLawShareOfVelocity = 0.995;

/// The law at parts + 1 instants of each segment, both of its ends included.
[[nodiscard]] std::vector<LawPoint> instants(const TimeLaw& law, int parts);

/// The largest s' of a law on parts of its path. Keeps no reference.
class FastestOf {
 public:
  explicit FastestOf(const TimeLaw& law);
  /// 1/s; a hair more than between the instants that are looked at. Realtime: setup.
  [[nodiscard]] double between(double s_begin, double s_end) const;

 private:
  std::vector<LawPoint> points_;
};

/// Parts for a path that is alike all along: what a law of seven segments does between two instants differs from the
/// next by less than 0.2 % of its largest rate.
inline constexpr int kPartsPerSegment = 16;

/// Diagnostics for limits that do not fit the chain, are not finite or not > 0.
void check_limits(const kinematics::Chain& chain, const JointLimits& limits, Diagnostics& diagnostics);
/// Diagnostics for options out of their range.
void check_options(const MotionOptions& options, Diagnostics& diagnostics);
/// Diagnostics for a configuration of the wrong size, not finite, or outside the range of a joint
/// (kinematics::kRangeTolerance), at `pointer`.
void check_configuration(const kinematics::Chain& chain, const JointLimits& limits, const JointVector& q,
                         const std::string& pointer, Diagnostics& diagnostics);
/// A diagnostic unless X is a rotation and a translation of finite numbers.
void check_pose(const Eigen::Isometry3d& X, const std::string& pointer, Diagnostics& diagnostics);
/// A diagnostic if what drives in a plane (kinematics::moves_in_plane) cannot reach X_BF because of what its joints
/// cannot do: "0.02 m along z". Nothing for other chains. @param q  where it stands. Realtime: setup.
void check_directions(const kinematics::InverseKinematics& inverse, const JointVector& q, const Eigen::Isometry3d& X_BF,
                      const std::string& pointer, Diagnostics& diagnostics);
/// "joint 'a2': 143.2 deg is outside its range" and the range as hint, in the units of files: deg or m.
void range_diagnostic(const kinematics::Chain& chain, const JointLimits& limits, int joint, double value,
                      const std::string& pointer, const std::string& where, Diagnostics& diagnostics);

/// On its way a joint leaves its range by rounding only (rad or m), as the guard sees to. Where it begins outside
/// (kinematics::kRangeTolerance) it may come back, but go no further out.
inline constexpr double kPathTolerance = 1e-11;

}  // namespace takt::motion
