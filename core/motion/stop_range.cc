#include "core/motion/stop_range.h"

#include <algorithm>
#include <cmath>

#include "core/motion/limits.h"

namespace takt::motion {
namespace {

struct Axis {
  double q, dq, ddq;

  void move(double jerk, double t) {
    q += t * (dq + t * (0.5 * ddq + t * jerk / 6.0));
    dq += t * (ddq + 0.5 * t * jerk);
    ddq += t * jerk;
  }
};

}  // namespace

double sideways_speed(double yaw, const JointVector& dq) { return std::cos(yaw) * dq[1] - std::sin(yaw) * dq[0]; }

double longest_stop(const JointLimits& limits) {
  // With ddq = a at the speed v the joint gains a^2/2j until the acceleration is gone, and loses it again.
  return (limits.velocity.array() / limits.acceleration.array() +
          2.5 * limits.acceleration.array() / limits.jerk.array())
      .maxCoeff();
}

StopRange stop_range(double q, double dq, double ddq, double acceleration, double jerk) {
  // What would remain once the acceleration is gone tells the direction in which to brake. Mirrored, it is forwards.
  const double coasting = dq + ddq * std::abs(ddq) / (2.0 * jerk);
  const double sign = coasting < 0.0 ? -1.0 : 1.0;
  Axis axis{sign * q, sign * dq, sign * ddq};
  double turning = axis.q;
  if (axis.dq < 0.0) {
    // Still backwards: it turns where the velocity changes its sign, before the braking has begun to bite.
    Axis back = axis;
    back.move(-jerk, (axis.ddq - std::sqrt(std::max(0.0, axis.ddq * axis.ddq + 2.0 * jerk * axis.dq))) / jerk);
    turning = back.q;
  }
  // Down to -peak, hold, up to 0: the areas under the three must take the velocity away.
  const double square = jerk * axis.dq + 0.5 * axis.ddq * axis.ddq;
  const double peak = std::min(std::sqrt(std::max(0.0, square)), acceleration);
  const double left = axis.dq + (axis.ddq * axis.ddq - 2.0 * peak * peak) / (2.0 * jerk);
  axis.move(-jerk, std::max(0.0, (axis.ddq + peak) / jerk));
  if (peak > 0.0) axis.move(0.0, std::max(0.0, left / peak));
  axis.move(jerk, peak / jerk);
  const double low = std::min({sign * q, turning, axis.q}), high = std::max({sign * q, turning, axis.q});
  return sign > 0.0 ? StopRange{low, high} : StopRange{-high, -low};
}

}  // namespace takt::motion
