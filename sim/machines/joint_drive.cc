#include "sim/machines/joint_drive.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace takt::sim {
namespace {

// Below this speed (rad/s) Coulomb friction fades to zero: slow against any motion that matters.
constexpr double kSmoothingSpeed = 0.005;
// Natural frequency (rad/s) of a closed brake and of static friction: far above the arm's motion, far below what a
// 1 ms step carries.
constexpr double kBrakeFrequency = 200.0;

}  // namespace

JointDrives::JointDrives(JointVector coulomb, JointVector viscous, const JointVector& inertia, JointVector brake_torque,
                         double timestep)
    : coulomb_(std::move(coulomb)), viscous_(std::move(viscous)), brake_(std::move(brake_torque)) {
  const auto n = coulomb_.size();
  smoothing_.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    // The slope at standstill acts as a damper; half the inertia per step keeps an explicit step stable.
    smoothing_[i] = std::max(kSmoothingSpeed, 2.0 * coulomb_[i] * timestep / inertia[i]);
  }
  locked_.setZero(n);
  stiffness_.setZero(n);
  damping_.setZero(n);
  limit_.setZero(n);
}

void JointDrives::friction(const JointVector& dq, JointVector& torque) const {
  for (Eigen::Index i = 0; i < dq.size(); ++i) {
    // x / sqrt(1 + x^2): as smooth as tanh, and without libm's transcendental functions the same bits everywhere.
    const double x = dq[i] / smoothing_[i];
    torque[i] = coulomb_[i] * x / std::sqrt(1.0 + x * x) + viscous_[i] * dq[i];
  }
}

void JointDrives::close(const JointVector& q, const JointVector& torque, const JointVector& inertia) {
  lock(q, torque, inertia, brake_);
}

void JointDrives::stick(const JointVector& q, const JointVector& inertia) {
  lock(q, JointVector::Zero(q.size()), inertia, coulomb_);
}

void JointDrives::lock(const JointVector& q, const JointVector& torque, const JointVector& inertia,
                       const JointVector& limit) {
  limit_ = limit;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    stiffness_[i] = inertia[i] * kBrakeFrequency * kBrakeFrequency;
    damping_[i] = 2.0 * inertia[i] * kBrakeFrequency;
    locked_[i] = q[i] + std::clamp(torque[i], -limit_[i], limit_[i]) / stiffness_[i];
  }
}

void JointDrives::holding_torque(const JointVector& q, const JointVector& dq, JointVector& torque) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double spring = stiffness_[i] * (locked_[i] - q[i]);
    const double held = std::clamp(spring, -limit_[i], limit_[i]);
    locked_[i] = q[i] + held / stiffness_[i];
    torque[i] = std::clamp(held - damping_[i] * dq[i], -limit_[i], limit_[i]);
  }
}

void JointDrives::stream(StateStream& state) {
  state.vector(locked_);
  state.vector(stiffness_);
  state.vector(damping_);
  state.vector(limit_);
}

}  // namespace takt::sim
