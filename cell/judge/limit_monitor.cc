#include "cell/judge/limit_monitor.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace takt::cell {

LimitMonitor::LimitMonitor(motion::JointLimits limits, std::vector<std::string> joint_names, double period_s,
                           kinematics::JointVector effort)
    : limits_(std::move(limits)),
      joint_names_(std::move(joint_names)),
      period_s_(period_s),
      effort_(std::move(effort)) {}

void LimitMonitor::watch(const device::Arm& arm) {
  const bool changed = arm.mode() != std::exchange(mode_, arm.mode());
  if (changed || arm.lost()) restart();
  // One that has fallen out is sent nothing.
  if (!arm.lost() && arm.set_point().q.size() > 0) add(arm.set_point().q);
}

void LimitMonitor::add_torque(const kinematics::JointVector& torque) {
  for (Eigen::Index i = 0; i < effort_.size() && i < torque.size(); ++i)
    if (std::isfinite(effort_[i])) note(kTorque, i, torque[i], effort_[i]);
}

void LimitMonitor::note(Quantity quantity, Eigen::Index joint, double value, double limit) {
  const double share = std::abs(value) / limit;
  // What is not a number is the worst there is, and stays it.
  if (share <= worst_share_ || std::isnan(worst_share_)) return;
  worst_share_ = share;
  worst_quantity_ = quantity;
  worst_joint_ = joint;
  worst_value_ = value;
  worst_limit_ = limit;
  worst_cycle_ = count_;
}

void LimitMonitor::add(const kinematics::JointVector& q) {
  if (!std::exchange(begun_, true)) {
    dq_ = ddq_ = kinematics::JointVector::Zero(q.size());
  } else {
    const kinematics::JointVector dq = (q - q_) / period_s_;
    const kinematics::JointVector ddq = (dq - dq_) / period_s_;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      note(kVelocity, i, dq[i], limits_.velocity[i]);
      note(kAcceleration, i, ddq[i], limits_.acceleration[i]);
      note(kJerk, i, (ddq[i] - ddq_[i]) / period_s_, limits_.jerk[i]);
    }
    dq_ = dq;
    ddq_ = ddq;
  }
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double middle = 0.5 * (limits_.lower[i] + limits_.upper[i]);
    if (std::isfinite(middle)) note(kPosition, i, q[i] - middle, limits_.upper[i] - middle);
  }
  q_ = q;
  ++count_;
}

LimitMonitor::Worst LimitMonitor::worst() const {
  static constexpr const char* kNames[] = {"position", "velocity", "acceleration", "jerk", "torque"};
  if (worst_cycle_ < 0) return {};
  return {worst_share_,
          fmt::format("{} of joint {}: {:.4g} of {:.4g} in cycle {}", kNames[worst_quantity_],
                      joint_names_[static_cast<std::size_t>(worst_joint_)], worst_value_, worst_limit_, worst_cycle_)};
}

}  // namespace takt::cell
