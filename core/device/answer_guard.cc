#include "core/device/answer_guard.h"

#include <algorithm>
#include <cmath>

#include "core/device/brake_ramp.h"

namespace takt::device {

namespace {

using Rule = Violation::Rule;

constexpr double kNoise = 3e-9;       // rad or m: set points may begin that far from where the arm was told to be
constexpr double kAnswerRangeNoise = 1e-4;  // rad or m: a stop may end that far outside, as the core's guard allows
// The polynomial between two set points meets a motion whose jerk switches between them but for this share of
// jerk * period in acceleration and of acceleration * period in velocity.
constexpr double kInterpolation = 0.25;

}  // namespace

AnswerGuard::AnswerGuard(const motion::JointLimits& limits, Nanoseconds core_period)
    : limits_(limits), core_period_(to_seconds(core_period)) {}

void AnswerGuard::rest_at(const JointVector& q, Nanoseconds instant) {
  last_ = {q, JointVector::Zero(q.size()), JointVector::Zero(q.size())};
  instant_ = instant;
}

void AnswerGuard::answered(const motion::JointSample& state, Nanoseconds instant) {
  last_ = state;
  instant_ = instant;
}

double AnswerGuard::speed(int joint) const {
  return limits_.velocity[joint] * (1.0 + Guard::kShare) + kInterpolation * core_period_ * limits_.acceleration[joint];
}

double AnswerGuard::acceleration(int joint) const {
  return limits_.acceleration[joint] * (1.0 + Guard::kShare) + kInterpolation * core_period_ * limits_.jerk[joint];
}

std::optional<Violation> AnswerGuard::check(const motion::JointSample& next, Nanoseconds instant) const {
  const auto joint_count = limits_.velocity.size();
  for (const JointVector* part : {&next.q, &next.dq, &next.ddq}) {
    if (part->size() != joint_count)
      return Violation{Rule::kSize, -1, static_cast<double>(part->size()), static_cast<double>(joint_count)};
    if (!part->allFinite()) return Violation{Rule::kNotFinite, -1, 0.0, 0.0};
  }
  const double dt = to_seconds(instant - instant_);
  if (last_.q.size() != joint_count || dt <= 0.0) return Violation{Rule::kMissing, -1, dt, 0.0};
  for (int i = 0; i < joint_count; ++i)
    if (const auto violation = check_joint(next, dt, i)) return violation;
  return std::nullopt;
}

std::optional<Violation> AnswerGuard::check_joint(const motion::JointSample& next, double dt, int i) const {
  const double v_max = speed(i), a_max = acceleration(i);
  const double q = next.q[i], dq = next.dq[i], ddq = next.ddq[i];
  const double lower = std::min(limits_.lower[i] - kAnswerRangeNoise, last_.q[i]);
  const double upper = std::max(limits_.upper[i] + kAnswerRangeNoise, last_.q[i]);
  if (q < lower) return Violation{Rule::kPosition, i, q, limits_.lower[i]};
  if (q > upper) return Violation{Rule::kPosition, i, q, limits_.upper[i]};

  const double mean = (q - last_.q[i]) / dt;
  if (std::abs(mean) > v_max + kNoise / dt) return Violation{Rule::kVelocity, i, mean, v_max};
  if (std::abs(dq) > v_max) return Violation{Rule::kVelocity, i, dq, v_max};
  if (std::abs(ddq) > a_max) return Violation{Rule::kAcceleration, i, ddq, a_max};
  const double kink = 0.5 * a_max * dt + kRateOpen * limits_.velocity[i] + kNoise / dt;
  for (const double end : {dq, last_.dq[i]})
    if (std::abs(mean - end) > kink) return Violation{Rule::kAcceleration, i, 2.0 * (mean - end) / dt, a_max};
  const double left = BrakeRamp::rest_velocity(dq, ddq, limits_.jerk[i]);
  if (std::abs(left) > v_max) return Violation{Rule::kVelocity, i, left, v_max};
  return std::nullopt;
}

}  // namespace takt::device
