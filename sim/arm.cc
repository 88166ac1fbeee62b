#include "sim/arm.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

JointVector zeros(int n) { return JointVector::Zero(n); }

/// Inertia that each joint moves alone, without payload, so rather too small than too large.
JointVector joint_inertia(const ArmPlant& plant, const JointVector& q) {
  return plant.chain.mass_matrix(q).diagonal() + plant.armature;
}

JointDrives make_drives(const ArmPlant& plant, double brake_factor) {
  const int n = plant.chain.joint_count();
  JointVector holding = plant.chain.effort_limit() * brake_factor;
  // A URDF without effort limits gives infinity; a brake needs a number.
  for (int i = 0; i < n; ++i) holding[i] = std::min(holding[i], 1e6);
  return {plant.coulomb, plant.viscous, joint_inertia(plant, zeros(n)), holding, plant.timestep};
}

JointVector filled(const JointVector& given, int n, double value) {
  return given.size() == n ? given : JointVector(JointVector::Constant(n, value));
}

bool is_finite(const device::ArmSetPoint& set_point, int n) {
  return set_point.q.size() == n && set_point.dq.size() == n && set_point.ddq.size() == n && set_point.q.allFinite() &&
         set_point.dq.allFinite() && set_point.ddq.allFinite();
}

}  // namespace

SimArm::SimArm(const SimArmDescription& description, ArmPlant plant, std::uint64_t seed)
    : control_(description.control),
      measurement_(description.measurement),
      payload_mass_error_(description.payload_mass_error),
      plant_(std::move(plant)),
      drives_(make_drives(plant_, control_.brake_factor)),
      noise_(seed, description.name) {
  const int n = plant_.chain.joint_count();
  q_ = dq_ = q_true_ = dq_true_ = motor_torque_ = joint_torque_ = zeros(n);
  set_point_.q = set_point_.dq = set_point_.ddq = zeros(n);
  sample_.q = sample_.dq = zeros(n);
  sample_.tau = zeros(measurement_.torque_sensors ? n : 0);
  control_.natural_frequency = filled(control_.natural_frequency, n, 60.0);
  control_.damping_ratio = filled(control_.damping_ratio, n, 1.0);
  measurement_.torque_noise = filled(measurement_.torque_noise, n, 0.0);
  torque_offset_ = filled(measurement_.torque_bias, n, 0.0);
  for (int i = 0; i < n; ++i) torque_offset_[i] *= noise_.normal();
  set_payload(plant_.payload);
}

bool SimArm::read(device::ArmSample& sample) {
  sample = sample_;
  sample.ready = !braked_;
  sample.fault = fault_;
  return sample_.sequence > 0;
}

void SimArm::write(const device::ArmSetPoint& set_point) {
  if (braked_) return;
  if (!is_finite(set_point, plant_.chain.joint_count())) {
    trip(ArmFault::kSetPointInvalid);
    return;
  }
  set_point_ = set_point;
  fresh_set_point_ = true;
}

void SimArm::set_payload(const device::PayloadSetting& payload) {
  payload_ = {payload.mass + payload_mass_error_, payload.p_FC, payload.I_C};
}

void SimArm::start(const mjData_& data) {
  gather(data);
  release_brakes();
}

void SimArm::brake() {
  if (braked_) return;
  braked_ = true;
  drives_.close(q_true_, joint_torque_, joint_inertia(plant_, q_true_));
}

void SimArm::trip(ArmFault fault) {
  if (fault_ == 0) fault_ = static_cast<std::uint32_t>(fault);
  brake();
}

void SimArm::release_brakes() {
  fault_ = 0;
  braked_ = false;
  fresh_set_point_ = false;
  set_point_.q = q_;
}

std::string SimArm::fault_text(std::uint32_t fault) const {
  switch (static_cast<ArmFault>(fault)) {
    case ArmFault::kNone:
      return "no fault";
    case ArmFault::kSetPointInvalid:
      return "set point not finite or of the wrong size";
    case ArmFault::kFollowingError:
      return "following error: a joint is too far from its set point";
    case ArmFault::kOverspeed:
      return "overspeed: a joint is faster than the controller allows";
  }
  return "unknown fault " + std::to_string(fault);
}

void SimArm::gather(const mjData_& data) {
  for (Eigen::Index i = 0; i < q_true_.size(); ++i) {
    q_true_[i] = data.qpos[plant_.position_address[static_cast<std::size_t>(i)]];
    dq_true_[i] = data.qvel[plant_.velocity_address[static_cast<std::size_t>(i)]];
  }
  q_ = q_true_;
  dq_ = dq_true_;
  const double step = measurement_.position_resolution;
  if (step > 0.0) {
    for (Eigen::Index i = 0; i < q_.size(); ++i) q_[i] = std::round(q_[i] / step) * step;
  }
  const double sigma = measurement_.velocity_noise;
  if (sigma > 0.0) {
    for (Eigen::Index i = 0; i < q_.size(); ++i) dq_[i] += sigma * noise_.normal();
  }
}

void SimArm::supervise() {
  const JointVector& limit = plant_.chain.velocity_limit();
  for (Eigen::Index i = 0; i < q_.size(); ++i) {
    if (std::abs(dq_[i]) > control_.overspeed_factor * limit[i]) return trip(ArmFault::kOverspeed);
    if (std::abs(set_point_.q[i] - q_[i]) > control_.following_error_limit) return trip(ArmFault::kFollowingError);
  }
}

void SimArm::compute_torque(double time_in_cycle) {
  const double h = time_in_cycle;
  const JointVector& w = control_.natural_frequency;
  const JointVector q_reference = set_point_.q + h * set_point_.dq + (0.5 * h * h) * set_point_.ddq;
  const JointVector dq_reference = set_point_.dq + h * set_point_.ddq;
  const JointVector damping = 2.0 * control_.damping_ratio.cwiseProduct(w);
  const JointVector acceleration =
      set_point_.ddq + damping.cwiseProduct(dq_reference - dq_) + w.cwiseProduct(w).cwiseProduct(q_reference - q_);
  JointVector friction = q_;
  drives_.friction(dq_reference, friction);
  motor_torque_ = plant_.chain.inverse_dynamics(q_, dq_, acceleration, plant_.gravity_B, payload_);
  motor_torque_ += plant_.armature.cwiseProduct(acceleration) + control_.friction_compensation * friction;
  const JointVector& limit = plant_.chain.effort_limit();
  motor_torque_ = motor_torque_.cwiseMin(limit).cwiseMax(-limit);
}

void SimArm::actuate(mjData_& data, int substep) {
  if (substep == 0 && !fresh_set_point_) {
    set_point_.dq.setZero();
    set_point_.ddq.setZero();
  }
  fresh_set_point_ = false;
  // At the begin of a cycle the drive still has what it measured at the end of the last one.
  if (substep > 0) gather(data);
  if (!braked_) supervise();

  JointVector torque = q_;
  drives_.friction(dq_true_, torque);
  if (braked_) {
    motor_torque_.setZero();
    JointVector held = q_;
    drives_.brake_torque(q_true_, dq_true_, held);
    torque = held - torque;
  } else {
    compute_torque(substep * plant_.timestep);
    torque = motor_torque_ - torque;
  }
  joint_torque_ = torque;
  for (Eigen::Index i = 0; i < torque.size(); ++i) {
    data.qfrc_applied[plant_.velocity_address[static_cast<std::size_t>(i)]] = torque[i];
  }
}

void SimArm::measure(const mjData_& data, Nanoseconds now) {
  for (Eigen::Index i = 0; i < joint_torque_.size(); ++i) {
    joint_torque_[i] -= plant_.armature[i] * data.qacc[plant_.velocity_address[static_cast<std::size_t>(i)]];
  }
  gather(data);
  ++sample_.sequence;
  sample_.stamp = now;
  sample_.q = q_;
  sample_.dq = dq_;
  for (Eigen::Index i = 0; i < sample_.tau.size(); ++i) {
    sample_.tau[i] = joint_torque_[i] + torque_offset_[i] + measurement_.torque_noise[i] * noise_.normal();
  }
}

void SimArm::stream(StateStream& state) {
  std::uint64_t random = noise_.state();
  state(random);
  noise_ = Random(random);
  drives_.stream(state);
  for (JointVector* values : {&q_, &dq_, &q_true_, &dq_true_, &motor_torque_, &joint_torque_, &set_point_.q,
                              &set_point_.dq, &set_point_.ddq, &sample_.tau}) {
    state.vector(*values);
  }
  sample_.q = q_;
  sample_.dq = dq_;
  state(set_point_.cycle);
  state(set_point_.stamp);
  state(fresh_set_point_);
  state(braked_);
  std::uint64_t fault = fault_;
  state(fault);
  fault_ = static_cast<std::uint32_t>(fault);
  state(sample_.sequence);
  state(sample_.stamp);
  state(payload_.mass);
  state.vector(payload_.p_FC);
  state.vector(payload_.I_C);
}

}  // namespace takt::sim
