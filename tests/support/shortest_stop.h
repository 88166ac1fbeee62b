#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/kinematics/inverse.h"
#include "core/motion/leg.h"

/// The shortest stop on a path that the limits of an arm allow, found by itself: it shares nothing with the planners
/// but the geometry of the path.
namespace takt::test {

/// Derivatives of the joints by s are differences of positions that inverse kinematics finds on a fine grid; a frame on
/// a line has its own. A stop takes the strongest jerk until some moment and from then on the opposite one, between the
/// limits of acceleration; the moment is found by bisection.
class ShortestStop {
 public:
  ShortestStop(const motion::ArmModel& arm, const motion::Motion& motion) : arm_(arm), motion_(motion) {
    kinematics::JointVector q = motion.q_start;
    for (std::size_t i = 0; i <= kNodes; ++i) {
      const auto there = motion::sample(motion.path, {.s = static_cast<double>(i) / kNodes});
      if (!there.cartesian)
        q = there.joints.q;
      else if (arm.inverse->solve(there.frame.X_BM * arm.X_FM.inverse(), there.held.q, q) != kinematics::IkStatus::kOk)
        break;
      q_.push_back(q);
    }
  }
  /// Every node of the path is known.
  [[nodiscard]] bool known() const { return q_.size() == kNodes + 1; }

  struct Stop {
    double s, time;
  };
  /// @param from  path time of the motion, s   @param rate  of its clock, steady, in (0, 1]
  [[nodiscard]] Stop from(double from, double rate) const {
    const motion::LawPoint law = motion_.law.at(from);
    const State begin{.s = law.s, .v = law.ds * rate, .b = law.dds * rate * rate};
    double low = 0.0, high = 2.0;  // s until the landing begins
    constexpr int kRounds = 30;
    for (int i = 0; i < kRounds; ++i) {
      const double middle = 0.5 * (low + high);
      (run(begin, middle).v > 0.0 ? low : high) = middle;
    }
    const State end = run(begin, high);
    return {.s = end.s, .time = end.t};
  }

 private:
  static constexpr std::size_t kNodes = 400;
  static constexpr double kStep = 1e-4;  // s

  struct State {
    double s, v, b, t = 0.0;
  };
  struct Range {
    double low = -1e300, high = 1e300;
    /// |by x + rest| <= limit
    void keep(double by, double rest, double limit) {
      if (std::abs(by) < 1e-9) return;
      const double one = (-limit - rest) / by, other = (limit - rest) / by;
      low = std::max(low, std::min(one, other));
      high = std::min(high, std::max(one, other));
    }
  };

  /// Calls visit(q', q'', q''', limits of acceleration and jerk) for each bounded quantity at s.
  template <class Visit>
  void look(double s, Visit visit) const {
    const auto k = std::clamp(static_cast<std::size_t>(s * kNodes + 0.5), std::size_t{2}, kNodes - 2);
    constexpr double h = 1.0 / kNodes;
    for (Eigen::Index i = 0; i < q_[0].size(); ++i) {
      const double a = q_[k - 2][i], b = q_[k - 1][i], c = q_[k][i], d = q_[k + 1][i], e = q_[k + 2][i];
      visit((d - b) / (2 * h), (d - 2 * c + b) / (h * h), (e - 2 * d + 2 * b - a) / (2 * h * h * h),
            arm_.limits.acceleration[i], arm_.limits.jerk[i]);
    }
    const auto* line = std::get_if<motion::CartesianLine>(&motion_.path);
    if (line == nullptr) return;
    visit(line->length, 0.0, 0.0, arm_.cartesian.linear_acceleration, arm_.cartesian.linear_jerk);
    visit(line->angle, 0.0, 0.0, arm_.cartesian.angular_acceleration, arm_.cartesian.angular_jerk);
  }

  /// Until the deceleration is gone or the arm at rest; v <= 0: it began to land too late.
  [[nodiscard]] State run(State now, double landing) const {
    while (now.v > 0.0 && now.s < 1.0 && !(now.t >= landing && now.b >= 0.0)) {
      Range jerk, acceleration;
      look(now.s, [&](double first, double second, double third, double a, double j) {
        acceleration.keep(first, second * now.v * now.v, a);
        jerk.keep(first, 3.0 * second * now.v * now.b + third * now.v * now.v * now.v, j);
      });
      // The landing may begin within a step: by whole steps it would end with a speed left, and so too soon.
      const double before = std::clamp(landing - now.t, 0.0, kStep);
      double b = now.b;
      if (before > 0.0) b = std::max(b + before * jerk.low, std::min(b, acceleration.low));
      b += (kStep - before) * jerk.high;
      now.s += kStep * (now.v + kStep / 6.0 * (2.0 * now.b + b));
      now.v += kStep / 2.0 * (now.b + b);
      now.b = b;
      now.t += kStep;
    }
    return now;
  }

  const motion::ArmModel arm_;
  const motion::Motion& motion_;
  std::vector<kinematics::JointVector> q_;
};

}  // namespace takt::test
