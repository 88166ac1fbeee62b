#include "sim/machines/base_drive.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

namespace takt::sim {
namespace {

Eigen::Vector2d turned(double angle, const Eigen::Vector2d& v) { return Eigen::Rotation2Dd(angle) * v; }

}  // namespace

BaseDrive::BaseDrive(const SimDriveDescription& description, Wheels wheels, const Support& support, std::uint64_t seed,
                     const std::string& name)
    : description_(description), wheels_(std::move(wheels)), support_(support), noise_(seed, name + "/odometry") {}

const kinematics::DifferentialDrive* BaseDrive::differential() const {
  return std::get_if<kinematics::DifferentialDrive>(&description_.drive);
}

bool BaseDrive::exact() const {
  return description_.error == OdometryError{} && differential() == nullptr && !has_slipped_;
}

void BaseDrive::start(const JointVector& q_true) {
  last_ = counted_ = q_true;
  deflection_ = 0.0;
}

void BaseDrive::count(const JointVector& q_true, const JointVector& dq_true, JointVector& q, JointVector& dq) {
  q = q_true;
  dq = dq_true;
  if (exact()) {
    last_ = counted_ = q_true;
    return;
  }
  const OdometryError& error = description_.error;
  if (slips_) {  // the wheels stand
    last_ = q_true;
    q = counted_;
    dq.setZero();
    return;
  }
  // The way in the axes of the body, half way between: what wheels can tell of it.
  const Eigen::Vector3d step = Eigen::Vector3d(q_true) - last_;
  Eigen::Vector2d way = turned(-(last_.z() + 0.5 * step.z()), step.head<2>());
  if (differential() != nullptr) way.y() = 0.0;
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

void BaseDrive::steer(const JointVector& q, const JointVector& dq_r, JointVector& q_r) const {
  constexpr double kLookAhead = 0.3;  // m: so far ahead on its line it steers for
  constexpr double kSlow = 0.05;      // m/s: below this it steers less, and not at all at rest
  if (differential() == nullptr) return;
  const Eigen::Vector2d ahead(std::cos(q_r[2]), std::sin(q_r[2]));
  const Eigen::Vector2d off = (q_r - q).head<2>();
  const double left = ahead.x() * off.y() - ahead.y() * off.x();
  const double speed = ahead.dot(Eigen::Vector2d(dq_r.head<2>()));
  q_r[2] += std::clamp(speed / kSlow, -1.0, 1.0) * std::atan(left / kLookAhead);
}

double BaseDrive::tyre_force(const kinematics::DifferentialDrive& drive, double speed_left, double duration) {
  constexpr double kDamping = 0.05;  // s: damping over stiffness
  const double most = drive.lateral_force / drive.lateral_stiffness;
  deflection_ = std::clamp(deflection_ + duration * speed_left, -most, most);
  const double force = -drive.lateral_stiffness * (deflection_ + kDamping * speed_left);
  return std::clamp(force, -drive.lateral_force, drive.lateral_force);
}

void BaseDrive::weigh(const mjData& data, double duration) {
  const Eigen::Map<const Eigen::Vector3d> force(data.sensordata + support_.force_address);
  const Eigen::Map<const Eigen::Vector3d> torque(data.sensordata + support_.torque_address);
  load_ = std::max(0.0, force.z());
  if (load_ > 0.0) {
    // The casters of two wheels on an axle are not known, so only sideways.
    const auto* mecanum = std::get_if<kinematics::MecanumDrive>(&description_.drive);
    const double track = mecanum != nullptr ? mecanum->track : differential()->track;
    beyond_ = std::abs(torque.x() / load_) - 0.5 * track;
    if (mecanum != nullptr) beyond_ = std::max(beyond_, std::abs(torque.y() / load_) - 0.5 * mecanum->wheelbase);
  } else {
    beyond_ = std::numeric_limits<double>::infinity();
  }
  beyond_for_ = beyond_ > 0.0 ? beyond_for_ + duration : 0.0;
}

JointVector BaseDrive::gripped(const JointVector& force, const JointVector& dq_true) {
  const double lever = std::visit([](const auto& drive) { return drive.lever(); }, description_.drive);
  const double along = force.head<2>().norm(), most = description_.grip * load_;
  JointVector result = force;
  bool beyond = false, backward = false;
  if (along > most) {
    result.head<2>() *= most / along;
    beyond = true;
    backward = force.head<2>().dot(dq_true.head<2>()) < 0.0;
  }
  if (std::abs(force[2]) > most * lever) {
    result[2] = std::copysign(most * lever, force[2]);
    beyond = true;
    backward = backward || force[2] * dq_true[2] < 0.0;
  }
  // What the wheels push against slides over the floor; what they drive takes them along.
  slips_ = beyond && backward;
  has_slipped_ = has_slipped_ || slips_;
  return result;
}

JointVector BaseDrive::on_plant(const JointVector& force, const JointVector& q_true, const JointVector& dq_true,
                                double duration) {
  JointVector result = force;
  if (!exact()) result.head<2>() = turned(last_.z() - counted_.z(), force.head<2>());
  return held(result, q_true, dq_true, duration);
}

JointVector BaseDrive::held(const JointVector& force, const JointVector& q_true, const JointVector& dq_true,
                            double duration) {
  const auto* drive = differential();
  if (drive == nullptr) return force;
  JointVector result = force;
  Eigen::Vector2d along = turned(-q_true[2], force.head<2>());
  along.y() = tyre_force(*drive, turned(-q_true[2], dq_true.head<2>()).y(), duration);
  result.head<2>() = turned(q_true[2], along);
  return result;
}

void BaseDrive::turn_wheels(mjData_& data, const JointVector& q_true, const JointVector& dq_true,
                            double duration) const {
  const Eigen::Vector2d v_F = turned(-q_true[2], dq_true.head<2>());
  const Eigen::Vector3d& p_FD = description_.X_FD.translation();
  const double w = dq_true[2];
  const Eigen::Vector3d twist(v_F.x() - w * p_FD.y(), v_F.y() + w * p_FD.x(), w);
  const auto speeds = kinematics::wheel_speeds(description_.drive, twist);
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const Wheel& wheel = wheels_[i];
    // What brings a free wheel to its speed within one step.
    const double lack = speeds[static_cast<Eigen::Index>(i)] - data.qvel[wheel.velocity_address];
    data.qfrc_applied[wheel.velocity_address] = wheel.inertia * lack / duration;
  }
}

void BaseDrive::stream(StateStream& state) {
  std::uint64_t random = noise_.state();
  state(random);
  noise_ = Random(random);
  state.vector(last_);
  state.vector(counted_);
  state(deflection_);
  state(load_);
  state(beyond_);
  state(beyond_for_);
  state(slips_);
  state(has_slipped_);
}

}  // namespace takt::sim
