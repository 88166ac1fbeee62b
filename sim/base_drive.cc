#include "sim/base_drive.h"

#include <cmath>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

namespace takt::sim {
namespace {

Eigen::Vector2d turned(double angle, const Eigen::Vector2d& v) { return Eigen::Rotation2Dd(angle) * v; }

}  // namespace

BaseDrive::BaseDrive(const SimDriveDescription& description, const Wheels& wheels, double timestep, std::uint64_t seed,
                     const std::string& name)
    : description_(description), wheels_(wheels), timestep_(timestep), noise_(seed, name + "/odometry") {}

bool BaseDrive::exact() const { return description_.error == OdometryError{}; }

void BaseDrive::start(const JointVector& q_true) { last_ = counted_ = q_true; }

void BaseDrive::count(const JointVector& q_true, const JointVector& dq_true, JointVector& q, JointVector& dq) {
  q = q_true;
  dq = dq_true;
  if (exact()) {
    last_ = counted_ = q_true;
    return;
  }
  const OdometryError& error = description_.error;
  // The way in the axes of the body, half way between: what wheels can tell of it.
  const Eigen::Vector3d step = Eigen::Vector3d(q_true) - last_;
  Eigen::Vector2d way = turned(-(last_.z() + 0.5 * step.z()), step.head<2>());
  const double length = way.norm();
  const double turn = error.angular_scale * step.z() + error.heading_drift * length;
  way *= error.linear_scale;
  if (error.random_walk > 0.0 && length > 0.0)
    way += error.random_walk * std::sqrt(length) * Eigen::Vector2d(noise_.normal(), noise_.normal());
  counted_.head<2>() += turned(counted_.z() + 0.5 * turn, way);
  counted_.z() += turn;
  last_ = q_true;
  const Eigen::Vector2d speed =
      turned(counted_.z() - last_.z(), error.linear_scale * Eigen::Vector2d(dq_true.head<2>()));
  q = counted_;
  dq << speed, error.angular_scale * dq_true[2] + error.heading_drift * dq_true.head<2>().norm();
}

JointVector BaseDrive::on_plant(const JointVector& force) const {
  JointVector result = force;
  if (!exact()) result.head<2>() = turned(last_.z() - counted_.z(), force.head<2>());
  return result;
}

void BaseDrive::turn_wheels(mjData_& data, const JointVector& q_true, const JointVector& dq_true) const {
  const Eigen::Vector2d v_F = turned(-q_true[2], dq_true.head<2>());
  const Eigen::Vector3d& p_FD = description_.X_FD.translation();
  const double w = dq_true[2];
  const Eigen::Vector3d twist(v_F.x() - w * p_FD.y(), v_F.y() + w * p_FD.x(), w);
  const auto speeds = description_.drive.wheel_speeds(twist);
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const Wheel& wheel = wheels_[i];
    // What brings a free wheel to its speed within one step.
    const double lack = speeds[static_cast<Eigen::Index>(i)] - data.qvel[wheel.velocity_address];
    data.qfrc_applied[wheel.velocity_address] = wheel.inertia * lack / timestep_;
  }
}

void BaseDrive::stream(StateStream& state) {
  std::uint64_t random = noise_.state();
  state(random);
  noise_ = Random(random);
  state.vector(last_);
  state.vector(counted_);
}

}  // namespace takt::sim
