#pragma once

#include <optional>

#include "core/base/time.h"
#include "core/device/guard.h"
#include "core/motion/limits.h"
#include "core/motion/path.h"

namespace takt::device {

/// The guard behind the I/O agent, the last code before the wire of a device that has a clock of its own (row S2). It
/// trusts neither the core's set points nor the agent's idea of time: it holds each answer to what was answered before,
/// over the time between the two instants of the device. For each joint
///   |q - q_before| <= speed() * dt                                     no step, no excess of speed,
///   |mean speed - dq|, |mean speed - dq_before| <= a * dt / 2 + noise  no kink at either end, so that the means of two
///                                                                      intervals differ by at most a * (dt + dt') / 2,
///   |ddq| <= a, and the speed that is left when a stop begins from here keeps speed(); inside the joint's range,
/// with the device's limits, a = acceleration(). It refuses, it never changes an answer; the agent then brakes from
/// what was answered last. One thread. Realtime: cyclic, O(n), no allocation.
class AnswerGuard {
 public:
  /// Most by which the rate of resampled time may differ from 1: the drift of the clocks and what corrects the estimate
  /// of it.
  static constexpr double kRateOpen = 700e-6;

  /// @param core_period  of the set points that answers are interpolated from. Realtime: setup.
  AnswerGuard(const motion::JointLimits& limits, Nanoseconds core_period);

  /// Starts a new history: at `instant` the device holds its joints at `q`.
  void rest_at(const JointVector& q, Nanoseconds instant);
  /// May this be answered for this instant? Changes nothing. @return what is wrong first, or nothing.
  [[nodiscard]] std::optional<Violation> check(const motion::JointSample& next, Nanoseconds instant) const;
  /// It was answered.
  void answered(const motion::JointSample& state, Nanoseconds instant);

  /// What was answered last, and for which instant of the device.
  [[nodiscard]] const motion::JointSample& last() const { return last_; }
  [[nodiscard]] Nanoseconds last_instant() const { return instant_; }
  /// Limits as they are held: with what interpolation between set points and the correction of time leave open. rad/s,
  /// rad/s^2 or the same in m.
  [[nodiscard]] double speed(int joint) const;
  [[nodiscard]] double acceleration(int joint) const;

 private:
  [[nodiscard]] std::optional<Violation> check_joint(const motion::JointSample& next, double dt, int joint) const;

  motion::JointLimits limits_;
  double core_period_;  // s
  motion::JointSample last_;
  Nanoseconds instant_ = 0;
};

}  // namespace takt::device
