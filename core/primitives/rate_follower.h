#pragma once

#include "core/kinematics/differential.h"
#include "core/motion/limits.h"
#include "core/motion/online_generator.h"
#include "core/motion/stop_range.h"

namespace takt::primitives {

/// Joints that follow wanted rates and never leave a limit: position, velocity, acceleration, jerk. Each cycle the
/// rates become targets of a jerk-limited generator. A joint whose next state could no longer stop in front of its
/// limit gets the target 0 instead, and that it can follow: the state before could stop. Owned by one primitive.
/// Realtime: cyclic but for the constructor.
class RateFollower {
 public:
  using State = motion::OnlineGenerator::State;

  explicit RateFollower(const motion::JointLimits& limits)
      : limits_(limits),
        generator_(static_cast<int>(limits.velocity.size()), motion::OnlineGenerator::Synchronization::kNone) {}

  /// At rest at q. @param margin  inside of the ranges that it keeps away from their ends; a joint that is nearer to
  /// one does not come nearer
  void start(const kinematics::JointVector& q, double margin = 0.0) {
    const kinematics::JointVector rest = kinematics::JointVector::Zero(q.size());
    lower_ = (limits_.lower.array() + margin).matrix().cwiseMin(q).cwiseMax(limits_.lower);
    upper_ = (limits_.upper.array() - margin).matrix().cwiseMax(q).cwiseMin(limits_.upper);
    generator_.start({.q = q, .dq = rest, .ddq = rest});
  }
  [[nodiscard]] const State& state() const { return generator_.state(); }

  /// Rates from which every joint can brake in good time: half of the acceleration, since it takes time to build up.
  /// What is wanted outside of them is refused later and less gently.
  [[nodiscard]] kinematics::RateBounds bounds(double dt) const {
    return kinematics::rate_bounds(state().q, lower_, upper_, limits_.velocity, 0.5 * limits_.acceleration, dt);
  }

  /// One period on. @return false: no number, or the generator knows no way
  bool advance(kinematics::JointVector target, double dt) {
    const State before = generator_.state();
    if (!step(target, dt)) return false;
    bool refused = false;
    const State& after = generator_.state();
    for (Eigen::Index i = 0; i < target.size(); ++i) {
      const auto range =
          motion::stop_range(after.q[i], after.dq[i], after.ddq[i], limits_.acceleration[i], limits_.jerk[i]);
      if (range.lowest >= lower_[i] && range.highest <= upper_[i]) continue;
      target[i] = 0.0;
      refused = true;
    }
    if (!refused) return true;
    generator_.start(before);
    return step(target, dt);
  }

 private:
  bool step(const kinematics::JointVector& target, double dt) {
    using enum motion::OnlineGenerator::Status;
    const auto status = generator_.follow_velocity(
        target, {.velocity = limits_.velocity, .acceleration = limits_.acceleration, .jerk = limits_.jerk}, dt);
    return status == kMoving || status == kArrived;
  }

  const motion::JointLimits& limits_;  ///< of the arm's description, which outlives every primitive
  kinematics::JointVector lower_, upper_;
  motion::OnlineGenerator generator_;
};

}  // namespace takt::primitives
