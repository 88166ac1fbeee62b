#pragma once

#include <string>
#include <string_view>

#include "core/kinematics/chain.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// Which of the solutions of its pose a joint vector is, in words, and how far it is from turning into another. The
/// names change only where the arm passes a singular posture, so they name the branches of a path too.
///
/// six axes, spherical wrist, axes 2 and 3 parallel (TX90, most industrial arms)
///   shoulder  front | back   the wrist centre lies ahead of axis 1 or behind it; ahead is where axis 2 is set off from
///                            axis 1, else where joint 2 leans with positive angles
///   elbow     up | down      the elbow lies above or below the line from axis 2 to the wrist centre, along axis 1
///   wrist     no flip | flip  the sign of (axis 4 x axis 6) . axis 5
/// six axes, three parallel (UR)
///   shoulder  left | right   seen from axis 1 towards the wrist's point (where axes 5 and 6 meet), axis 1 up: the
///   arm's
///                            offset along its parallel axes lies to the left or to the right
///   elbow     up | down      as above, for the triangle of axes 2, 3 and 4 with the wrist ahead
///   wrist     no flip | flip  as above
/// seven axes, S-R-S (LWR): the signs of (axis 1 x axis 3) . axis 2, (axis 3 x axis 5) . axis 4, (axis 5 x axis 7) .
///   axis 6, called front | back, up | down, no flip | flip; the first word stands for a joint that bends the arm from
///   its zero posture towards x of the base. Where the elbow is in the room says the arm angle, not the branch
/// any other six axes: no such reading; `aspect` "+" or "-" is the sign of the Jacobian's determinant
/// any other chain: all empty.
struct Posture {
  std::string_view shoulder, elbow, wrist, aspect;

  /// "front, up, no flip", "aspect +", or "" where the geometry has no reading.
  [[nodiscard]] std::string name() const;
};

/// How near a singular posture is. All values are plain numbers: the linear rows of the Jacobian are divided by the
/// arm's reach.
struct Singularity {
  /// Smallest singular value of the Jacobian (exact): 0 = singular.
  double measure = 0.0;
  double manipulability = 0.0;  ///< product of the singular values (Yoshikawa 1985)
  double condition = 0.0;       ///< smallest over largest, in [0, 1]
  /// The nearest kind of singular posture: "shoulder" (wrist over axis 1), "elbow" (arm stretched or folded), "wrist"
  /// (axes 4 and 6 in line), for S-R-S arms also "shoulder and wrist"; where the geometry has no such reading, the two
  /// joints that work against each other most, by name.
  std::string nearest;
  /// How far that one is: the sine of the angle at the elbow or wrist, or the wrist's distance over the reach, 0..1;
  /// the measure where the geometry has no reading.
  double distance = 0.0;
  /// measure < kSingularMeasure: rates do not exist, and solutions there are one of infinitely many.
  bool singular = false;
};

inline constexpr double kSingularMeasure = 1e-6;

/// How far the joints are from their limits.
struct LimitMargin {
  double distance = 0.0;  ///< of the nearest one, rad or m; negative outside; +infinity without limits
  int joint = -1;         ///< which joint that is; -1 without limits
};

/// Realtime: setup, all three; q has joint_count() entries.
[[nodiscard]] Posture posture(const Chain& chain, const JointVector& q);
[[nodiscard]] Singularity singularity(const Chain& chain, const JointVector& q);
[[nodiscard]] LimitMargin limit_margin(const Chain& chain, const JointVector& q);

}  // namespace takt::kinematics
