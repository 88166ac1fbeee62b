#include "core/device/brake_ramp.h"

#include <algorithm>
#include <cmath>

namespace takt::device {

namespace {

/// Velocity that is left when the acceleration is brought to zero at once.
double coasting_velocity(double v, double a, double jerk) { return v + a * std::abs(a) / (2.0 * jerk); }

double toward(double from, double to, double jerk) { return to >= from ? jerk : -jerk; }

}  // namespace

BrakeRamp::Axis BrakeRamp::fastest(double q, double v, double a, double a_max, double jerk) {
  Axis axis{.q = q, .v = v, .a = a, .jerk = jerk};
  const double coasting = coasting_velocity(v, a, jerk);
  const double side = coasting > 0.0 ? 1.0 : -1.0;  // the axis brakes against this direction
  const double v_side = side * v, a_side = side * a;
  // Without a hold the peak p follows from p^2 = J v + a^2 / 2.
  double peak = std::sqrt(std::max(0.0, jerk * v_side + 0.5 * a_side * a_side));
  const double allowed = std::max(a_max, -a_side);  // a state beyond the limit is not made worse
  if (peak > allowed) {
    peak = allowed;
    axis.t_hold = std::max(0.0, (v_side + (0.5 * a_side * a_side - peak * peak) / jerk) / peak);
  }
  axis.peak = -side * peak;
  axis.t_to_peak = std::max(0.0, (a_side + peak) / jerk);
  axis.t_to_zero = peak / jerk;
  axis.q_end = axis.at(axis.duration()).q;
  return axis;
}

BrakeRamp::Axis BrakeRamp::stretched(const Axis& fast, double duration) {
  if (duration <= fast.duration()) return fast;
  Axis axis = fast;
  const double coasting = coasting_velocity(fast.v, fast.a, fast.jerk);
  const double side = coasting > 0.0 ? 1.0 : -1.0;
  const double v = side * fast.v, a = side * fast.a, jerk = fast.jerk;
  // Braking already harder than needed: ease off to the peak, then hold. Else build the peak up; the smaller root of
  // p^2 + p (a - J T) + J v + a^2 / 2 = 0 is the one that reaches T.
  const double eased = side * coasting / (duration + std::min(0.0, a) / jerk);
  double peak = eased;
  if (a >= 0.0 || eased > -a) {
    const double half = 0.5 * (jerk * duration - a);
    const double product = jerk * v + 0.5 * a * a;
    const double root = half + std::sqrt(std::max(0.0, half * half - product));
    peak = root > 0.0 ? product / root : 0.0;
  }
  axis.peak = -side * peak;
  axis.t_to_peak = std::abs(peak + a) / jerk;
  axis.t_to_zero = peak / jerk;
  axis.t_hold = std::max(0.0, duration - axis.t_to_peak - axis.t_to_zero);
  axis.q_end = axis.at(axis.duration()).q;
  return axis;
}

BrakeRamp::Axis::Point BrakeRamp::Axis::at(double time) const {
  Point point{q, v, a};
  const auto run = [&point](double j, double t) {
    point.q += t * (point.v + t * (point.a / 2.0 + t * j / 6.0));
    point.v += t * (point.a + t * j / 2.0);
    point.a += t * j;
  };
  const double first = std::min(time, t_to_peak);
  run(toward(a, peak, jerk), first);
  if (time <= t_to_peak) return point;
  point.a = peak;
  const double second = std::min(time - t_to_peak, t_hold);
  run(0.0, second);
  const double left = time - t_to_peak - t_hold;
  if (left > 0.0) run(toward(peak, 0.0, jerk), std::min(left, t_to_zero));
  return point;
}

double BrakeRamp::rest_velocity(double v, double a, double jerk) { return coasting_velocity(v, a, jerk); }

double BrakeRamp::stopping_point(double q, double v, double a, double a_max, double jerk) {
  return fastest(q, v, a, a_max, jerk).q_end;
}

BrakeRamp::BrakeRamp(const motion::JointSample& state, const motion::JointLimits& limits)
    : count_(static_cast<int>(state.q.size())) {
  for (int i = 0; i < count_; ++i) {
    Axis& axis = axes_[static_cast<std::size_t>(i)];
    axis = fastest(state.q[i], state.dq[i], state.ddq[i], limits.acceleration[i], limits.jerk[i]);
    duration_ = std::max(duration_, axis.duration());
  }
  for (int i = 0; i < count_; ++i) {
    Axis& axis = axes_[static_cast<std::size_t>(i)];
    const Axis together = stretched(axis, duration_);
    const bool in_range = together.q_end >= limits.lower[i] && together.q_end <= limits.upper[i];
    if (in_range) axis = together;
  }
}

motion::JointSample BrakeRamp::sample(double time) const {
  motion::JointSample sample;
  sample.q.resize(count_);
  sample.dq = JointVector::Zero(count_);
  sample.ddq = JointVector::Zero(count_);
  for (int i = 0; i < count_; ++i) {
    const Axis& axis = axes_[static_cast<std::size_t>(i)];
    sample.q[i] = axis.q_end;
    if (time >= duration_ || time >= axis.duration()) continue;
    const Axis::Point point = axis.at(time);
    sample.q[i] = point.q;
    sample.dq[i] = point.v;
    sample.ddq[i] = point.a;
  }
  return sample;
}

}  // namespace takt::device
