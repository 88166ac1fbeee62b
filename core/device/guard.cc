#include "core/device/guard.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/device/brake_ramp.h"

namespace takt::device {

namespace {

using Rule = Violation::Rule;

constexpr double kRestVelocity = 1e-6;      // rad/s: 1 um/s at a metre
constexpr double kRestAcceleration = 1e-3;  // rad/s^2
constexpr double kRangeNoise = 1e-4;        // rad or m: what kShare in the derivatives does to a stopping distance

std::string_view symbol(Rule rule) {
  switch (rule) {
    case Rule::kPosition:
    case Rule::kStart:
      return "rad";
    case Rule::kVelocity:
      return "rad/s";
    case Rule::kSideways:
      return "m/s";
    case Rule::kAcceleration:
      return "rad/s2";
    case Rule::kJerk:
      return "rad/s3";
    default:
      return "";
  }
}

/// m/s: what curved paths between two set points, and the interpolation of plans, leave sideways.
constexpr double kSidewaysNoise = 1e-4;
constexpr int kSidewaysJoint = 1;  // y: of the joints it is the one that is meant

bool exceeds(double value, double limit, double noise) {
  return std::abs(value) > limit * (1.0 + Guard::kShare) + noise;
}

/// A stop that begins here goes on from q with dq and ddq, whatever they were before. Its first two third differences
/// are `first` + J h^3 / 6 and `second` + 5 J h^3 / 6 with the jerk J of the stop. In a motion of bounded jerk both
/// parts are what these bounds say, so they cost planners nothing.
/// `d1`, `d1_old`: the last steps in q; h: the period.
std::optional<Violation> check_seam(const ArmSetPoint& next, int i, double d1, double d1_old, double h, double j_max) {
  const double h3 = h * h * h;
  const double step = h * next.dq[i], bend = 0.5 * h * h * next.ddq[i];
  const double first = step + bend - 2.0 * d1 + d1_old, second = d1 - step + bend;
  if (exceeds(second, j_max * h3 / 6.0, 4.0 * Guard::kPositionNoise))
    return Violation{Rule::kInconsistent, i, second, j_max * h3 / 6.0};
  if (exceeds(first, j_max * h3 * 5.0 / 6.0, 8.0 * Guard::kPositionNoise))
    return Violation{Rule::kJerk, i, first / h3, j_max * 5.0 / 6.0};
  return std::nullopt;
}

}  // namespace

std::string_view name_of(Rule rule) {
  switch (rule) {
    case Rule::kMissing:
      return "no set point";
    case Rule::kSize:
      return "wrong number of joints";
    case Rule::kNotFinite:
      return "not finite";
    case Rule::kPosition:
      return "position";
    case Rule::kVelocity:
      return "velocity";
    case Rule::kAcceleration:
      return "acceleration";
    case Rule::kJerk:
      return "jerk";
    case Rule::kInconsistent:
      return "q, dq, ddq disagree by";
    case Rule::kSideways:
      return "sideways";
    case Rule::kStart:
      return "net starts at";
  }
  return "";
}

Guard::Guard(const motion::JointLimits& limits, double period) : limits_(limits), period_(period) {}

void Guard::rest_at(const JointVector& q) {
  last_.q = q;
  last_.dq = JointVector::Zero(q.size());
  last_.ddq = JointVector::Zero(q.size());
  older_ = {q, q};
}

bool Guard::rests(const ArmSetPoint& set_point) {
  for (int i = 0; i < set_point.dq.size(); ++i)
    if (std::abs(set_point.dq[i]) > kRestVelocity || std::abs(set_point.ddq[i]) > kRestAcceleration) return false;
  return true;
}

void Guard::sent(const ArmSetPoint& set_point) {
  older_[1] = older_[0];
  older_[0] = last_.q;
  last_ = set_point;
}

std::optional<Violation> Guard::check(const ArmSetPoint& set_point) const {
  const auto joint_count = limits_.velocity.size();
  for (const JointVector* part : {&set_point.q, &set_point.dq, &set_point.ddq})
    if (part->size() != joint_count)
      return Violation{Rule::kSize, -1, static_cast<double>(part->size()), static_cast<double>(joint_count)};
  if (!set_point.q.allFinite() || !set_point.dq.allFinite() || !set_point.ddq.allFinite()) {
    for (int i = 0; i < joint_count; ++i)
      for (const double x : {set_point.q[i], set_point.dq[i], set_point.ddq[i]})
        if (!std::isfinite(x)) return Violation{Rule::kNotFinite, i, x, 0.0};
  }
  if (last_.q.size() != joint_count) return Violation{Rule::kMissing, -1, 0.0, 0.0};
  for (int i = 0; i < joint_count; ++i)
    if (const auto violation = check_joint(set_point, i)) return violation;
  return limits_.nonholonomic ? check_rolling(set_point) : std::nullopt;
}

std::optional<Violation> Guard::check_rolling(const ArmSetPoint& next) const {
  constexpr int kYaw = 2;
  const JointVector step = (next.q - last_.q) / period_;
  // The chord of an arc runs along the heading in its middle.
  const double of_step = motion::sideways_speed(0.5 * (next.q[kYaw] + last_.q[kYaw]), step);
  const double of_field = motion::sideways_speed(next.q[kYaw], next.dq);
  for (const double speed : {of_step, of_field})
    if (std::abs(speed) > kSidewaysNoise) return Violation{Rule::kSideways, kSidewaysJoint, speed, kSidewaysNoise};
  return std::nullopt;
}

std::optional<Violation> Guard::check_joint(const ArmSetPoint& next, int i) const {
  const double h = period_, q = next.q[i];
  const double v_max = limits_.velocity[i], a_max = limits_.acceleration[i], j_max = limits_.jerk[i];
  // Who stands outside may come back, but go no further out: a stop may end there by kRangeNoise, a hand may push it.
  const double lower = std::min(limits_.lower[i], last_.q[i]), upper = std::max(limits_.upper[i], last_.q[i]);
  if (q < lower - kPositionNoise) return Violation{Rule::kPosition, i, q, limits_.lower[i]};
  if (q > upper + kPositionNoise) return Violation{Rule::kPosition, i, q, limits_.upper[i]};

  // Differences of what is sent: means over one, two and three periods, so that a motion within its limits is always
  // within them here.
  const double d1 = q - last_.q[i], d1_old = last_.q[i] - older_[0][i], d1_older = older_[0][i] - older_[1][i];
  const double d2 = d1 - d1_old, d2_old = d1_old - d1_older;
  const double v = d1 / h, a = d2 / (h * h), j = (d2 - d2_old) / (h * h * h);
  if (exceeds(v, v_max, 2.0 * kPositionNoise / h)) return Violation{Rule::kVelocity, i, v, v_max};
  if (exceeds(a, a_max, 4.0 * kPositionNoise / (h * h))) return Violation{Rule::kAcceleration, i, a, a_max};
  if (exceeds(j, j_max, 8.0 * kPositionNoise / (h * h * h))) return Violation{Rule::kJerk, i, j, j_max};

  if (const auto violation = check_derivatives(next, i, d1)) return violation;
  if (const auto violation = check_seam(next, i, d1, d1_old, h, j_max)) return violation;
  return check_future(next, i);
}

std::optional<Violation> Guard::check_derivatives(const ArmSetPoint& next, int i, double d1) const {
  const double h = period_, dq = next.dq[i], ddq = next.ddq[i];
  const double v_max = limits_.velocity[i], a_max = limits_.acceleration[i], j_max = limits_.jerk[i];
  // The derivatives that go with it: within the limits, and of the same motion. What a motion of bounded jerk leaves
  // open between two cycles bounds the disagreement (error of the trapezoidal rule).
  const double step = (ddq - last_.ddq[i]) / h;
  if (exceeds(dq, v_max, 2.0 * kPositionNoise / h)) return Violation{Rule::kVelocity, i, dq, v_max};
  if (exceeds(ddq, a_max, 4.0 * kPositionNoise / (h * h))) return Violation{Rule::kAcceleration, i, ddq, a_max};
  if (exceeds(step, j_max, 8.0 * kPositionNoise / (h * h * h))) return Violation{Rule::kJerk, i, step, j_max};
  const double dq_gap = dq - last_.dq[i] - 0.5 * h * (ddq + last_.ddq[i]);
  const double q_gap = d1 - 0.5 * h * (dq + last_.dq[i]);
  const double dq_open = j_max * h * h / 4.0, q_open = j_max * h * h * h / 12.0;
  if (exceeds(dq_gap, dq_open, 4.0 * kPositionNoise / h)) return Violation{Rule::kInconsistent, i, dq_gap, dq_open};
  if (exceeds(q_gap, q_open, 2.0 * kPositionNoise)) return Violation{Rule::kInconsistent, i, q_gap, q_open};
  return std::nullopt;
}

std::optional<Violation> Guard::check_future(const ArmSetPoint& next, int i) const {
  const double v_max = limits_.velocity[i], a_max = limits_.acceleration[i], j_max = limits_.jerk[i];
  const double q = next.q[i], dq = next.dq[i], ddq = next.ddq[i];
  const double v_rest = BrakeRamp::rest_velocity(dq, ddq, j_max);
  if (exceeds(v_rest, v_max, 2.0 * kPositionNoise / period_)) return Violation{Rule::kVelocity, i, v_rest, v_max};
  // The way to rest is never longer than this; most of the time the range is further away.
  const double longest =
      std::abs(dq) * (0.5 * std::abs(dq) / a_max + 2.0 * a_max / j_max) + 2.0 * a_max * a_max * a_max / (j_max * j_max);
  if (q - longest >= limits_.lower[i] && q + longest <= limits_.upper[i]) return std::nullopt;
  const double q_stop = BrakeRamp::stopping_point(q, dq, ddq, a_max, j_max);
  const double lower = std::min(limits_.lower[i] - kRangeNoise, last_.q[i] - kPositionNoise);
  const double upper = std::max(limits_.upper[i] + kRangeNoise, last_.q[i] + kPositionNoise);
  if (q_stop < lower) return Violation{Rule::kPosition, i, q_stop, limits_.lower[i]};
  if (q_stop > upper) return Violation{Rule::kPosition, i, q_stop, limits_.upper[i]};
  return std::nullopt;
}

net::Text describe(const Violation& violation, const std::vector<std::string>& joint_names) {
  std::array<char, 63> text;
  const auto room = text.size();
  const std::string_view what = name_of(violation.rule), unit = symbol(violation.rule);
  fmt::format_to_n_result<char*> end{text.data(), 0};
  const auto joint = static_cast<std::size_t>(violation.joint);
  const bool whole = violation.joint < 0;
  if (whole) {
    end = fmt::format_to_n(text.data(), room, "{}", what);
  } else if (joint < joint_names.size()) {
    end = fmt::format_to_n(text.data(), room, "joint {}: {}", joint_names[joint], what);
  } else {
    end = fmt::format_to_n(text.data(), room, "joint {}: {}", violation.joint + 1, what);
  }
  auto used = std::min(end.size, room);
  if (!whole && violation.rule != Rule::kNotFinite) {
    const std::string_view than = violation.rule == Rule::kStart ? ", arm is at" : " beyond";
    end = fmt::format_to_n(text.data() + used, room - used, " {:.5g}{} {:.5g} {}", violation.value, than,
                           violation.limit, unit);
    used += std::min(end.size, room - used);
  }
  return net::Text(std::string_view(text.data(), used));
}

}  // namespace takt::device
