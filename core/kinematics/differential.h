#pragma once

#include "core/kinematics/chain.h"
#include "core/kinematics/types.h"

namespace takt::kinematics {

/// How well the flange can be moved at q. Realtime: cyclic.
struct Dexterity {
  double manipulability = 0.0;  ///< product of the singular values (Yoshikawa 1985)
  double smallest = 0.0;        ///< smallest singular value: 0 = singular
  double condition = 0.0;       ///< smallest over largest, in [0, 1]
};
/// Of the Jacobian with its linear rows divided by `length` (m), so that all values are plain numbers.
[[nodiscard]] Dexterity dexterity(const Jacobian& J, double length);

/// Bounds of joint rates, rad/s or m/s; lower <= upper for each joint.
struct RateBounds {
  JointVector lower, upper;
};

/// The rates of one period (s) with which each joint can still stop in front of its limits by losing acceleration *
/// period in each period that follows, and |dq| <= velocity. All arrays have one number per joint; lower and upper may
/// be infinite. Realtime: cyclic.
[[nodiscard]] RateBounds rate_bounds(const JointVector& q, const JointVector& lower, const JointVector& upper,
                                     const JointVector& velocity, const JointVector& acceleration, double period);

/// Joint rates that come nearest to a flange twist V_BF_B within bounds: damped least squares; a joint whose bound is
/// hit is held there and the others take over what they can, at most once per joint.
/// @param length   what linear rows are divided by, m   @param damped_below  singular value below which it is damped
/// @return rates inside the bounds, always. Realtime: cyclic, bounded, no allocation.
/// Source: Nakamura, Hanafusa 1986 (damping); holding joints as in Flacco, De Luca, Khatib 2015.
[[nodiscard]] JointVector bounded_rates(const Jacobian& J, const Vector6& V_BF_B, const RateBounds& bounds,
                                        double length, double damped_below);

}  // namespace takt::kinematics
