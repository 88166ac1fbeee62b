#pragma once

#include <array>

#include "core/kinematics/types.h"
#include "core/motion/limits.h"
#include "core/motion/path.h"

namespace takt::device {

using kinematics::JointVector;

/// The way from any state of motion to rest: every axis goes through three pieces of constant jerk, and all axes come
/// to rest at the same instant, that of the axis which needs longest. An axis that would leave its range in that time
/// brakes alone, as fast as it may.
///
/// From a state within the limits that can be kept within them at all (|dq + ddq |ddq| / (2 jerk)| <= velocity) no
/// limit of velocity, acceleration or jerk is exceeded. Ranges are kept where the limits of acceleration and jerk allow
/// it. Source: own derivation (docs/devices.md, "Braking").
class BrakeRamp {
 public:
  /// Not started: rest with no joints.
  BrakeRamp() = default;

  /// @param state  where the arm is told to be and how it moves: q, dq, ddq of one size, finite.
  /// @param limits as many joints. Realtime: cyclic, O(n), closed form.
  BrakeRamp(const motion::JointSample& state, const motion::JointLimits& limits);

  /// Time from the start to rest of the last axis, s.
  [[nodiscard]] double duration() const { return duration_; }

  /// Where the axes are `time` (s, >= 0) after the start; from duration() on the same bits for ever, derivatives 0.
  /// Realtime: cyclic.
  [[nodiscard]] motion::JointSample sample(double time) const;

  /// One axis: the velocity that is left when the acceleration goes to zero as fast as the jerk allows. Beyond the
  /// limit, that limit cannot be kept any more. Realtime: cyclic.
  [[nodiscard]] static double rest_velocity(double v, double a, double jerk);
  /// One axis: where the fastest stop ends. Realtime: cyclic.
  [[nodiscard]] static double stopping_point(double q, double v, double a, double a_max, double jerk);

 private:
  /// Jerk +-J to the acceleration `peak`, hold it, jerk to zero.
  struct Axis {
    double q = 0.0, v = 0.0, a = 0.0;
    double jerk = 1.0;  ///< magnitude
    double peak = 0.0;
    double t_to_peak = 0.0, t_hold = 0.0, t_to_zero = 0.0;
    double q_end = 0.0;

    struct Point {
      double q, v, a;
    };
    [[nodiscard]] double duration() const { return t_to_peak + t_hold + t_to_zero; }
    [[nodiscard]] Point at(double time) const;
  };

  [[nodiscard]] static Axis fastest(double q, double v, double a, double a_max, double jerk);
  [[nodiscard]] static Axis stretched(const Axis& fastest, double duration);

  std::array<Axis, kinematics::kMaxJoints> axes_;
  int count_ = 0;
  double duration_ = 0.0;
};

}  // namespace takt::device
