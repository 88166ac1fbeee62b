#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/device/arm.h"
#include "core/kinematics/types.h"
#include "core/motion/limits.h"

namespace takt::cell {

/// Differentiates the positions that an arm was really sent, once per cycle, and remembers the worst of each limit.
/// An oracle: it shares nothing with planner and guard but the limits. Differences over one cycle are means of the
/// derivative over that cycle, so a signal inside its limits stays inside here but for rounding.
/// Realtime: cyclic, no allocation after construction.
class LimitMonitor {
 public:
  /// @param effort  Nm or N, what the motors have; size 0: torques are not looked at
  LimitMonitor(motion::JointLimits limits, std::vector<std::string> joint_names, double period_s,
               kinematics::JointVector effort = {});

  /// What the arm was sent in this cycle. Where it was taken over anew it begins anew: after it was lost, or out of a
  /// mode of impedance, where it goes on where it is, which need not be where its springs rest.
  void watch(const device::Arm& arm);
  /// The set point of this cycle; rad or m.
  void add(const kinematics::JointVector& q);
  /// What the motors are asked for in this cycle, before it is cut to what they have; Nm or N.
  void add_torque(const kinematics::JointVector& torque);
  /// The next set point is no continuation of the last: the arm was taken over anew.
  void restart() { begun_ = false; }

  /// Worst use of any limit so far: 1 = exactly at the limit.
  struct Worst {
    double share = 0.0;
    std::string what;  ///< "jerk of joint a3: 212.4 of 160 in cycle 1204"
  };
  [[nodiscard]] Worst worst() const;
  /// Shares up to this count as inside: rounding of positions of some rad, seen through three differences over 1 ms.
  static constexpr double kTolerance = 1e-4;
  [[nodiscard]] bool held() const { return worst_share_ <= 1.0 + kTolerance; }

 private:
  enum Quantity { kPosition, kVelocity, kAcceleration, kJerk, kTorque };
  void note(Quantity quantity, Eigen::Index joint, double value, double limit);

  motion::JointLimits limits_;
  std::vector<std::string> joint_names_;
  double period_s_;
  kinematics::JointVector effort_;
  device::ControlMode mode_ = device::ControlMode::kPosition;
  std::int64_t count_ = 0;
  bool begun_ = false;
  kinematics::JointVector q_, dq_, ddq_;
  double worst_share_ = 0.0;
  Quantity worst_quantity_ = kPosition;
  Eigen::Index worst_joint_ = 0;
  double worst_value_ = 0.0, worst_limit_ = 0.0;
  std::int64_t worst_cycle_ = -1;
};

}  // namespace takt::cell
