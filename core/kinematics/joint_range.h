#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/kinematics/chain.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// rad or m: a joint that is no further beyond an end of its range stands at that end. The one tolerance for starts,
/// goals and solutions: files round degrees and poses, encoders round positions, and a stop may end that far outside
/// (the guard). What is planned ends at the end itself.
inline constexpr double kRangeTolerance = 1e-4;

/// Inside the range, or at one of its ends. False for what is not finite. Realtime: cyclic, as all below.
[[nodiscard]] inline bool is_in_range(double q, double lower, double upper) {
  return q >= lower - kRangeTolerance && q <= upper + kRangeTolerance;
}

/// The end where a joint stands at it, else q as it is.
[[nodiscard]] inline double into_range(double q, double lower, double upper) {
  return is_in_range(q, lower, upper) && lower <= upper ? std::clamp(q, lower, upper) : q;
}

[[nodiscard]] inline JointVector into_range(JointVector q, const JointVector& lower, const JointVector& upper) {
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = into_range(q[i], lower[i], upper[i]);
  return q;
}

/// The part of a joint's range where postures are looked for: of a joint that turns one turn, around zero where the
/// range has that; of one that slides 10 m.
struct OneTurn {
  double low, high;
};
[[nodiscard]] inline OneTurn one_turn(const Chain& chain, int joint) {
  const double lower = chain.lower()[joint], upper = chain.upper()[joint];
  const double most = chain.is_prismatic(joint) ? 10.0 : std::numbers::pi;
  if (lower <= -most && upper >= most) return {-most, most};
  if (lower > -most) return {lower, std::min(upper, lower + 2.0 * most)};
  return {std::max(lower, upper - 2.0 * most), upper};
}

/// The same posture: each joint that turns without limits in the turn that is nearest to `near`.
[[nodiscard]] inline JointVector in_nearest_turns(const Chain& chain, JointVector q, const JointVector& near) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (int i = 0; i < chain.joint_count(); ++i) {
    const bool endless = !chain.is_prismatic(i) && std::isinf(chain.lower()[i]) && std::isinf(chain.upper()[i]);
    if (endless) q[i] += kTurn * std::round((near[i] - q[i]) / kTurn);
  }
  return q;
}

}  // namespace takt::kinematics
