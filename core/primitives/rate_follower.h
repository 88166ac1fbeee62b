#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/kinematics/differential.h"
#include "core/motion/limits.h"
#include "core/motion/online_generator.h"
#include "core/motion/stop_range.h"
#include "core/primitives/arm_kinematics.h"

namespace takt::primitives {

/// How fast a tool may be, m/s and rad/s.
struct ToolBounds {
  double linear = std::numeric_limits<double>::infinity();
  double angular = std::numeric_limits<double>::infinity();

  /// Share from which joints are held back: targets may go up to 1, and what follows them is never exact.
  static constexpr double kTooFast = 1.002;

  [[nodiscard]] bool bounded() const { return std::isfinite(linear) || std::isfinite(angular); }
  /// Velocity of the tool over its bound; 1 or less: inside.
  [[nodiscard]] double share(const kinematics::Vector6& V) const {
    return std::max(V.head<3>().norm() / linear, V.tail<3>().norm() / angular);
  }
};

/// Joints that follow wanted rates and never leave a limit: position, velocity, acceleration, jerk. Each cycle the
/// rates become targets of a jerk-limited generator. Each joint goes there as soon as it can, which is what controllers
/// around it want. Of a bounded tool all joints are led there at the same time: so the rates on the way lie between
/// those of now and the wanted ones, and a tool that is slow enough at both is so in between. A cycle after which it
/// could become too fast is not gone: its joints lose their accelerations instead, unless all are to stop. A joint
/// whose next state could no longer stop in front of its limit gets the target 0, and that it can follow: the state
/// before could stop. Likewise a joint that would become too fast itself. That comes before the speed of the tool.
/// Owned by one primitive. Realtime: cyclic but for the constructor.
class RateFollower {
 public:
  using State = motion::OnlineGenerator::State;

  RateFollower(const motion::JointLimits& limits, const ToolBounds& tool)
      : limits_(limits),
        tool_(tool),
        usual_(static_cast<int>(limits.velocity.size()), tool.bounded()
                                                             ? motion::OnlineGenerator::Synchronization::kPhase
                                                             : motion::OnlineGenerator::Synchronization::kNone),
        each_(static_cast<int>(limits.velocity.size()), motion::OnlineGenerator::Synchronization::kNone) {}

  /// At rest at q. @param margin  inside of the ranges that it keeps away from their ends; a joint that is nearer to
  /// one does not come nearer
  void start(const kinematics::JointVector& q, double margin = 0.0) {
    const kinematics::JointVector rest = kinematics::JointVector::Zero(q.size());
    lower_ = (limits_.lower.array() + margin).matrix().cwiseMin(q).cwiseMax(limits_.lower);
    upper_ = (limits_.upper.array() - margin).matrix().cwiseMax(q).cwiseMin(limits_.upper);
    usual_.start({.q = q, .dq = rest, .ddq = rest});
  }
  [[nodiscard]] const State& state() const { return usual_.state(); }

  /// Rates from which every joint can brake in good time: half of the acceleration, since it takes time to build up.
  /// What is wanted outside of them is refused later and less gently.
  [[nodiscard]] kinematics::RateBounds bounds(double dt) const {
    return kinematics::rate_bounds(state().q, lower_, upper_, limits_.velocity, 0.5 * limits_.acceleration, dt);
  }

  /// One period on. @param kinematics  looked at state().q; then it has looked elsewhere   @return false: no number, or
  /// the generator knows no way
  bool advance(kinematics::JointVector target, double dt, ArmKinematics& kinematics) {
    const Jacobians J = jacobians(kinematics);
    const State before = state();
    if (!step(usual_, target, dt)) return false;
    if (!target.isZero() && too_fast(state(), J)) {
      target = bounded(calmed(before), J);
      usual_.start(before);
      if (!step(usual_, target, dt)) return false;
    }
    if (!refuse(state(), target) && !overshoots(state())) return true;
    target = bounded(target, J);
    each_.start(before);
    if (!step(each_, target, dt)) return false;
    // Those that were led there more slowly before may be too near to an end now.
    if (refuse(each_.state(), target)) {
      each_.start(before);
      if (!step(each_, target, dt)) return false;
    }
    usual_.start(each_.state());
    return true;
  }

 private:
  using JointVector = kinematics::JointVector;
  static constexpr double kRounding = 1e-9;

  /// Of the tool where it is, and where it will be by the time that joints could have changed their rates.
  struct Jacobians {
    kinematics::Jacobian now, ahead;
  };
  [[nodiscard]] Jacobians jacobians(ArmKinematics& kinematics) const {
    if (!tool_.bounded()) return {kinematics.J_BT, kinematics.J_BT};
    Jacobians J{.now = kinematics.J_BT, .ahead = {}};
    const double time = 2.0 * (limits_.acceleration.array() / limits_.jerk.array()).maxCoeff();
    kinematics.look(JointVector(state().q + time * state().dq));
    J.ahead = kinematics.J_BT;
    return J;
  }

  bool step(motion::OnlineGenerator& generator, const JointVector& target, double dt) const {
    using enum motion::OnlineGenerator::Status;
    const auto status = generator.follow_velocity(
        target, {.velocity = limits_.velocity, .acceleration = limits_.acceleration, .jerk = limits_.jerk}, dt);
    return status == kMoving || status == kArrived;
  }

  [[nodiscard]] double share(const JointVector& dq, const Jacobians& J) const {
    return std::max(tool_.share(J.now * dq), tool_.share(J.ahead * dq));
  }
  /// All by one factor, so that neither the tool nor a joint is too fast.
  [[nodiscard]] JointVector bounded(const JointVector& dq, const Jacobians& J) const {
    const double of_joints = (dq.array().abs() / limits_.velocity.array()).maxCoeff();
    return dq / std::max({1.0, share(dq, J), of_joints});
  }
  /// The rates once all joints have lost their accelerations together.
  [[nodiscard]] JointVector calmed(const State& state) const {
    const double time = (state.ddq.array().abs() / limits_.jerk.array()).maxCoeff();
    return state.dq + 0.5 * time * state.ddq;
  }
  [[nodiscard]] bool too_fast(const State& state, const Jacobians& J) const {
    return share(state.dq, J) > ToolBounds::kTooFast || share(calmed(state), J) > ToolBounds::kTooFast;
  }

  /// A joint becomes faster than it may before it has lost its acceleration: joints that are led to their rates
  /// together may do so, one that goes there as soon as it can does not.
  [[nodiscard]] bool overshoots(const State& after) const {
    const auto peak = after.dq.array() + 0.5 * after.ddq.array() * after.ddq.array().abs() / limits_.jerk.array();
    return (peak.abs() > (1.0 + kRounding) * limits_.velocity.array()).any();
  }

  /// Joints that could no longer stop inside their ranges get the target 0. @return whether there are any
  bool refuse(const State& after, JointVector& target) const {
    bool any = false;
    for (Eigen::Index i = 0; i < target.size(); ++i) {
      const auto range =
          motion::stop_range(after.q[i], after.dq[i], after.ddq[i], limits_.acceleration[i], limits_.jerk[i]);
      if (range.lowest >= lower_[i] && range.highest <= upper_[i]) continue;
      target[i] = 0.0;
      any = true;
    }
    return any;
  }

  const motion::JointLimits& limits_;  ///< of the arm's description, which outlives every primitive
  JointVector lower_, upper_;
  ToolBounds tool_;
  motion::OnlineGenerator usual_;  ///< holds the state
  motion::OnlineGenerator each_;   ///< every joint as soon as it can
};

}  // namespace takt::primitives
