#include "sim/machines/arm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

using device::ControlMode;
using device::StopCategory;

/// s, in which the difference of two laws fades away after a change of the mode.
constexpr double kFadeTime = 0.2;
/// Cycles for which an external torque has to be too large before the arm stops: an impact is over sooner.
constexpr std::int64_t kProtectiveCycles = 10;
/// rad/s or m/s: slower joints stand, for a change of the mode.
constexpr double kStandstill = 0.02;
/// m/s or rad/s: what is slower is held by static friction.
constexpr double kStuckSpeed = 1e-3;

JointVector zeros(Eigen::Index n) { return JointVector::Zero(n); }

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

ArmFault fault_of(StopCategory category) {
  return static_cast<ArmFault>(static_cast<std::uint32_t>(ArmFault::kStopped0) + static_cast<std::uint32_t>(category));
}

std::uint32_t fault_word(ArmFault fault, Eigen::Index joint) {
  return static_cast<std::uint32_t>(fault) | (static_cast<std::uint32_t>(joint + 1) << 8);
}

std::size_t cycles_of(Nanoseconds time, double period) {
  return static_cast<std::size_t>(std::llround(to_seconds(time) / period));
}

}  // namespace

SimArm::SimArm(const SimArmDescription& description, ArmPlant plant, std::uint64_t seed)
    : control_(description.control),
      measurement_(description.measurement),
      payload_mass_error_(description.payload_mass_error),
      plant_(std::move(plant)),
      drives_(make_drives(plant_, control_.brake_factor)),
      law_(control_, plant_, drives_),
      friction_(filled(control_.friction_observer, plant_.chain.joint_count(), 0.0), control_.friction_uncertainty),
      observer_(plant_.chain.joint_count()),
      noise_(seed, description.name),
      line_(cycles_of(measurement_.delay, plant_.period),
            std::max<std::size_t>(1, cycles_of(measurement_.period, plant_.period))) {
  const int n = plant_.chain.joint_count();
  q_ = dq_ = q_true_ = dq_true_ = motor_torque_ = joint_torque_ = wanted_torque_ = fading_ = zeros(n);
  set_point_.q = set_point_.dq = set_point_.ddq = zeros(n);
  device::ArmSample sample;
  sample.q = sample.dq = zeros(n);
  sample.tau = sample.tau_external = zeros(measurement_.torque_sensors ? n : 0);
  line_.reset(sample);
  control_.natural_frequency = filled(control_.natural_frequency, n, 60.0);
  control_.damping_ratio = filled(control_.damping_ratio, n, 1.0);
  measurement_.torque_noise = filled(measurement_.torque_noise, n, 0.0);
  torque_offset_ = filled(measurement_.torque_bias, n, 0.0);
  for (int i = 0; i < n; ++i) torque_offset_[i] *= noise_.normal();
  set_payload(plant_.payload);
  compliance_ = control_.impedance.standard(control_.modes.modes.front());
}

bool SimArm::read(device::ArmSample& sample) {
  sample = line_.visible();
  sample.ready = !braked_ && !own_stop_;
  sample.braked = braked_;
  sample.fault = fault_;
  if (braked_) sample.tau_external.resize(0);  // the brakes carry what no sensor tells of
  return sequence_ > 0;
}

device::BackendTiming SimArm::timing() const {
  const auto cycle = static_cast<Nanoseconds>(std::llround(plant_.period * 1e9));
  const Nanoseconds thinned = std::max<Nanoseconds>(0, measurement_.period - cycle);
  return {.cycle = 0, .sample_age = measurement_.delay + thinned, .driver_delay = 0, .dead_time = 0};
}

void SimArm::write(const device::ArmSetPoint& set_point) {
  if (!follows()) return;
  if (!is_finite(set_point, plant_.chain.joint_count())) return trip(ArmFault::kSetPointInvalid);
  set_point_ = set_point;
  fresh_set_point_ = true;
}

void SimArm::write_compliance(const device::Compliance& compliance) {
  if (!follows() || compliance.mode != compliance_.mode || compliance.mode == ControlMode::kPosition) return;
  const device::ComplianceRange& range = control_.impedance.range(compliance.mode);
  if (find_fault(compliance, compliance, range, 1.0)) return trip(ArmFault::kComplianceInvalid);
  if (compliance.in_tool_axes != compliance_.in_tool_axes) fade_from_last_torque();
  compliance_ = compliance;
}

void SimArm::change_mode(ControlMode mode) {
  const device::ModeChange* change = control_.modes.find(compliance_.mode, mode);
  if (!follows() || change == nullptr) return;
  if (change->change == device::ChangeClass::kSeamless) return enter(mode);
  const bool stands =
      set_point_.dq.isZero(0.0) && set_point_.ddq.isZero(0.0) && dq_.cwiseAbs().maxCoeff() < kStandstill;
  if (stands) change_ = Change{mode, static_cast<std::int64_t>(cycles_of(change->duration, plant_.period))};
}

void SimArm::enter(ControlMode mode) {
  // Position begins where the arm is: what pushed it away from the rest of a spring must not make it jump back.
  if (mode == ControlMode::kPosition && set_point_.dq.isZero(0.0)) set_point_.q = q_;
  compliance_ = control_.impedance.standard(mode);
  fade_from_last_torque();
}

void SimArm::continue_change() {
  if (!change_ || --change_->cycles_left > 0) return;
  const ControlMode to = change_->to;
  change_.reset();
  enter(to);
}

void SimArm::set_payload(const device::PayloadSetting& payload) {
  payload_ = {payload.mass + payload_mass_error_, payload.p_FC, payload.I_C};
}

void SimArm::set_tool(const device::ToolSetting& tool) {
  set_payload(tool.payload);
  X_FT_ = tool.X_FT;
}

void SimArm::start(const mjData_& data) {
  read_plant(data);
  if (plant_.drive) plant_.drive->start(q_true_);
  gather(data);
  release_brakes();
}

void SimArm::brake() {
  if (braked_) return;
  braked_ = true;
  stuck_ = false;
  own_stop_.reset();
  change_.reset();
  fade_ = 0.0;
  friction_.reset();
  drives_.close(q_true_, joint_torque_, joint_inertia(plant_, q_true_));
}

void SimArm::trip(ArmFault fault, Eigen::Index joint) {
  if (fault_ == 0) fault_ = fault_word(fault, joint);
  brake();
}

void SimArm::stop(StopCategory category) {
  if (braked_ || (own_stop_ && own_stop_->category <= category)) return;
  fault_ = static_cast<std::uint32_t>(fault_of(category));
  const bool can_plan = control_.limits.velocity.size() == set_point_.q.size();
  if (category == StopCategory::kBrakes || !can_plan) return brake();
  if (own_stop_) {
    own_stop_->category = category;  // it brakes already
  } else {
    const motion::JointSample begin{set_point_.q, set_point_.dq, set_point_.ddq};
    own_stop_ = OwnStop{.category = category, .begin = begin, .ramp = device::BrakeRamp(begin, control_.limits)};
  }
}

/// One cycle of the controlled stop; a spring's feed-forward goes away as fast as the device may.
void SimArm::follow_own_stop() {
  own_stop_->time += plant_.period;
  const motion::JointSample at = own_stop_->ramp.sample(own_stop_->time);
  set_point_.q = at.q;
  set_point_.dq = at.dq;
  set_point_.ddq = at.ddq;
  bool relaxed = true;
  if (compliance_.mode != ControlMode::kPosition) {
    const device::ComplianceRange& range = control_.impedance.range(compliance_.mode);
    const device::Compliance target = stopped(compliance_, range);
    compliance_ = approach(compliance_, target, range, plant_.period / to_seconds(control_.impedance.ramp));
    relaxed = compliance_ == target;
  }
  const bool over = own_stop_->time >= own_stop_->ramp.duration() && relaxed;
  if (over && own_stop_->category == StopCategory::kStopThenBrakes) brake();
}

void SimArm::release_brakes() {
  fault_ = 0;
  braked_ = false;
  own_stop_.reset();
  fresh_set_point_ = false;
  set_point_.q = q_;
  set_point_.dq.setZero();
  set_point_.ddq.setZero();
  compliance_ = control_.impedance.standard(compliance_.mode);
  observer_.reset();
  pushed_cycles_ = 0;
}

std::string SimArm::fault_text(std::uint32_t fault) const {
  const auto& names = plant_.chain.joint_names();
  const std::size_t number = fault >> 8;
  const std::string joint =
      number > 0 && number <= names.size() ? fmt::format("joint {}", names[number - 1]) : "a joint";
  switch (fault_kind(fault)) {
    case ArmFault::kNone:
      return "no fault";
    case ArmFault::kSetPointInvalid:
      return "set point not finite or of the wrong size";
    case ArmFault::kFollowingError:
      return fmt::format("following error: {} is too far from its set point", joint);
    case ArmFault::kOverspeed:
      return fmt::format("overspeed: {} is faster than the controller allows", joint);
    case ArmFault::kComplianceInvalid:
      return "stiffness, damping or feed-forward outside what the device allows";
    case ArmFault::kStopped0:
      return "stopped by category 0: brakes";
    case ArmFault::kStopped1:
      return "stopped by category 1: controlled stop, then brakes";
    case ArmFault::kStopped2:
      return "stopped by category 2: controlled stop, held in position";
    case ArmFault::kExternalTorque:
      return fmt::format("protective stop: the external torque on {} is too large", joint);
    case ArmFault::kTips:
      return plant_.drive && std::isfinite(plant_.drive->beyond())
                 ? fmt::format("it tips over: the load is {:.0f} mm beyond its wheels", 1e3 * plant_.drive->beyond())
                 : "it tips over: nothing is left on its wheels";
  }
  return "unknown fault " + std::to_string(fault);
}

void SimArm::read_plant(const mjData_& data) {
  for (Eigen::Index i = 0; i < q_true_.size(); ++i) {
    q_true_[i] = data.qpos[plant_.position_address[static_cast<std::size_t>(i)]];
    dq_true_[i] = data.qvel[plant_.velocity_address[static_cast<std::size_t>(i)]];
  }
}

void SimArm::gather(const mjData_& data) {
  read_plant(data);
  q_ = q_true_;
  dq_ = dq_true_;
  if (plant_.drive) plant_.drive->count(q_true_, dq_true_, q_, dq_);
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
  const bool stiff = compliance_.mode == ControlMode::kPosition && !change_;
  for (Eigen::Index i = 0; i < q_.size(); ++i) {
    if (std::abs(dq_[i]) > control_.overspeed_factor * limit[i]) return trip(ArmFault::kOverspeed, i);
    const bool away = std::abs(set_point_.q[i] - q_[i]) > control_.following_error_limit;
    if (stiff && away) return trip(ArmFault::kFollowingError, i);
  }
}

/// What the integral part of the position law adds. A spring gives way to friction as to anything else, so springs have
/// none.
JointVector SimArm::unknown_friction(double duration) {
  if (compliance_.mode != ControlMode::kPosition) {
    friction_.reset();
    return zeros(q_.size());
  }
  const JointVector acceleration = friction_.acceleration(dq_, duration);
  JointVector modelled = q_;
  drives_.friction(dq_, modelled);
  const JointVector needed = plant_.chain.inverse_dynamics(q_, dq_, acceleration, plant_.gravity_B, payload_) +
                             plant_.armature.cwiseProduct(acceleration) + control_.friction_compensation * modelled;
  friction_.update(needed, motor_torque_, duration);
  return friction_.compensation(modelled, dq_);
}

void SimArm::compute_torque(const Substep& step) {
  const double h = step.begin();
  JointVector q_r = set_point_.q + h * set_point_.dq + (0.5 * h * h) * set_point_.ddq;
  if (plant_.drive) plant_.drive->steer(q_, set_point_.dq, q_r);
  const ArmTask task{.q = q_,
                     .dq = dq_,
                     .q_r = q_r,
                     .dq_r = set_point_.dq + h * set_point_.ddq,
                     .ddq_r = set_point_.ddq,
                     .compliance = compliance_,
                     .payload = payload_,
                     .X_FT = X_FT_};
  JointVector torque = law_.torque(task);
  if (friction_.active()) torque += unknown_friction(step.duration);
  if (fade_ > 0.0) {
    if (fade_ == 1.0) fading_ = wanted_torque_ - torque;
    torque += fade_ * fading_;
    fade_ = std::max(0.0, fade_ - step.duration / kFadeTime);
  }
  wanted_torque_ = torque;
  const JointVector& limit = plant_.chain.effort_limit();
  motor_torque_ = torque.cwiseMin(limit).cwiseMax(-limit);
}

void SimArm::take_set_point() {
  continue_change();
  if (own_stop_) {
    follow_own_stop();
  } else if (!fresh_set_point_) {
    set_point_.dq.setZero();
    set_point_.ddq.setZero();
  }
}

void SimArm::actuate(mjData_& data, const Substep& step) {
  if (step.number == 0) take_set_point();
  fresh_set_point_ = false;
  // At the begin of a cycle the drive still has what it measured at the end of the last one.
  if (step.number > 0) gather(data);
  if (!braked_) supervise();

  if (braked_) {
    motor_torque_.setZero();
    wanted_torque_.setZero();
  } else {
    compute_torque(step);
    if (plant_.drive) stick_or_let_go();
  }
  if (stands() && data.body_awake[plant_.root] == mjS_ASLEEP) return;

  const JointVector torque = torque_on_plant(step.duration);
  if (plant_.drive) plant_.drive->turn_wheels(data, q_true_, dq_true_, step.duration);
  joint_torque_ = torque;
  for (Eigen::Index i = 0; i < torque.size(); ++i) {
    data.qfrc_applied[plant_.velocity_address[static_cast<std::size_t>(i)]] = torque[i];
  }
}

/// Static friction takes what the drives of a base that stands do with the noise of its odometry.
void SimArm::stick_or_let_go() {
  const bool at_rest = set_point_.dq.isZero(0.0) && set_point_.ddq.isZero(0.0);
  const bool weak = (motor_torque_.cwiseAbs() - drives_.coulomb()).maxCoeff() < 0.0;
  if (!at_rest || !weak) {
    stuck_ = false;
  } else if (!stuck_ && dq_true_.cwiseAbs().maxCoeff() < kStuckSpeed) {
    stuck_ = true;
    drives_.stick(q_true_, joint_inertia(plant_, q_true_));
  }
}

/// What motors, friction, and what holds the joints do to them.
JointVector SimArm::torque_on_plant(double duration) {
  JointVector friction = q_;
  const auto gripped = [this](const JointVector& torque) {
    return plant_.drive ? plant_.drive->gripped(torque, dq_true_) : torque;
  };
  if (braked_ || stuck_) {
    JointVector held = q_;
    drives_.holding_torque(q_true_, dq_true_, held);
    if (stuck_) return gripped(plant_.drive->held(held, q_true_, dq_true_, duration));
    drives_.friction(dq_true_, friction);
    return gripped(held - friction);
  }
  drives_.friction(dq_true_, friction);
  if (!plant_.drive) return motor_torque_ - friction;
  return gripped(plant_.drive->on_plant(motor_torque_, q_true_, dq_true_, duration) - friction);
}

/// Torques that a motor's current tells of hold the friction of its joint and what accelerates its rotor; only what is
/// known of both can be taken out.
void SimArm::estimate_external(const device::ArmSample& sample) {
  const JointVector acceleration = observer_.acceleration(dq_, plant_.period);
  JointVector inertial = plant_.chain.inverse_dynamics(q_, dq_, acceleration, plant_.gravity_B, payload_);
  JointVector torque = sample.tau;
  if (measurement_.torque_at_motor) {
    JointVector friction = q_;
    drives_.friction(dq_, friction);
    torque -= control_.friction_compensation * friction;
    inertial += plant_.armature.cwiseProduct(acceleration);
  }
  observer_.update(inertial, torque, JointVector::Constant(q_.size(), measurement_.observer_gain), plant_.period);
}

/// A controlled stop, then brakes, when the estimate of the external torques has been too large for a while.
void SimArm::protect() {
  const JointVector& limit = control_.protective_torque;
  const JointVector& estimate = observer_.estimate();
  if (limit.size() == 0 || limit.size() != estimate.size() || braked_) return;
  Eigen::Index joint = 0;
  const bool too_large = (estimate.cwiseAbs() - limit).maxCoeff(&joint) > 0.0;
  pushed_cycles_ = too_large ? pushed_cycles_ + 1 : 0;
  if (pushed_cycles_ < kProtectiveCycles || own_stop_) return;
  stop(StopCategory::kStopThenBrakes);
  fault_ = fault_word(ArmFault::kExternalTorque, joint);
}

void SimArm::measure(const mjData_& data, Nanoseconds now) {
  for (Eigen::Index i = 0; i < joint_torque_.size(); ++i) {
    joint_torque_[i] -= plant_.armature[i] * data.qacc[plant_.velocity_address[static_cast<std::size_t>(i)]];
  }
  if (plant_.drive) {
    plant_.drive->weigh(data, plant_.period);
    if (plant_.drive->tips()) trip(ArmFault::kTips);
  }
  gather(data);
  device::ArmSample sample;
  sample.sequence = ++sequence_;
  sample.stamp = now;
  sample.q = q_;
  sample.dq = dq_;
  sample.mode = compliance_.mode;
  sample.changing_mode = change_.has_value();
  sample.braked = braked_;
  if (measurement_.torque_sensors) {
    sample.tau = measurement_.torque_at_motor ? motor_torque_ : joint_torque_;
    for (Eigen::Index i = 0; i < sample.tau.size(); ++i)
      sample.tau[i] += torque_offset_[i] + measurement_.torque_noise[i] * noise_.normal();
    braked_ ? observer_.reset() : estimate_external(sample);
    sample.tau_external = observer_.estimate();
    protect();
  }
  line_.push(sample);
}

void SimArm::stream(StateStream& state) {
  std::uint64_t random = noise_.state();
  state(random);
  noise_ = Random(random);
  drives_.stream(state);
  if (plant_.drive) plant_.drive->stream(state);
  friction_.stream(state);
  observer_.stream(state);
  for (JointVector* values : {&q_, &dq_, &q_true_, &dq_true_, &motor_torque_, &joint_torque_, &set_point_.q,
                              &set_point_.dq, &set_point_.ddq, &wanted_torque_, &fading_}) {
    state.vector(*values);
  }
  state(fade_);
  state(set_point_.cycle);
  state(set_point_.stamp);
  state(fresh_set_point_);
  state(braked_);
  state(stuck_);
  std::uint64_t fault = fault_;
  state(fault);
  fault_ = static_cast<std::uint32_t>(fault);
  state(sequence_);
  state(pushed_cycles_);
  line_.stream(state);
  state(payload_.mass);
  state.vector(payload_.p_FC);
  state.vector(payload_.I_C);
  stream_mode(state);
}

/// Everything about modes and stops. Vectors whose size depends on the mode travel in buffers of one size.
void SimArm::stream_mode(StateStream& state) {
  auto mode = static_cast<std::uint64_t>(compliance_.mode);
  state(mode);
  compliance_.mode = static_cast<ControlMode>(mode);
  state(compliance_.in_tool_axes);
  for (JointVector* values : {&compliance_.stiffness, &compliance_.damping_ratio, &compliance_.feed_forward}) {
    std::array<double, kinematics::kMaxJoints> buffer{};
    std::int64_t size = values->size();
    std::copy_n(values->data(), values->size(), buffer.begin());
    state(size);
    state.vector(buffer);
    values->resize(size);
    std::copy_n(buffer.begin(), values->size(), values->data());
  }
  state(compliance_.nullspace_stiffness);
  state(compliance_.nullspace_damping_ratio);
  bool changing = change_.has_value();
  Change change = change_.value_or(Change{});
  auto to = static_cast<std::uint64_t>(change.to);
  state(changing);
  state(to);
  state(change.cycles_left);
  change.to = static_cast<ControlMode>(to);
  change_ = changing ? std::optional(change) : std::nullopt;
  stream_stop(state);
  state.vector(X_FT_.matrix());
}

/// A stop under way is where it is by its ramp, which follows from where it began.
void SimArm::stream_stop(StateStream& state) {
  bool stopping = own_stop_.has_value();
  OwnStop stop = own_stop_.value_or(OwnStop{});
  if (!stopping) stop.begin.q = stop.begin.dq = stop.begin.ddq = zeros(q_.size());
  auto category = static_cast<std::uint64_t>(stop.category);
  state(stopping);
  state(category);
  state(stop.time);
  for (JointVector* values : {&stop.begin.q, &stop.begin.dq, &stop.begin.ddq}) state.vector(*values);
  if (!stopping) return own_stop_.reset();
  stop.category = static_cast<StopCategory>(category);
  stop.ramp = device::BrakeRamp(stop.begin, control_.limits);
  own_stop_ = stop;
}

}  // namespace takt::sim
