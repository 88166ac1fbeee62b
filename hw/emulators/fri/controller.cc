#include "hw/emulators/fri/controller.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/kinematics/inverse.h"
#include "core/kinematics/pose_error.h"
#include "core/net/format_text.h"
#include "hw/fri/protocol/krl_words.h"

namespace takt::hw::fri {
namespace {

using device::ControlMode;

constexpr Nanoseconds kKrlCycle = 12 * kMillisecond;  // the KRC's interpolation cycle
constexpr Nanoseconds kStartTimeout = 5 * kSecond;    // of friStart(), ours
constexpr std::size_t kMostNews = 64;                 // that nobody fetched
constexpr int kMirrorCycles = 3;                      // until a new place of the arm comes back as a command

/// What a binary32 on the wire keeps of it.
Joints as_on_wire(const Joints& q) { return q.cast<float>().cast<double>(); }

ControlMode mode_of(Control control) {
  if (control == Control::kJointImpedance) return ControlMode::kJointImpedance;
  return control == Control::kCartesianImpedance ? ControlMode::kCartesianImpedance : ControlMode::kPosition;
}

std::uint32_t position_flag(Control control) {
  return control == Control::kCartesianImpedance ? kCartesianPosition : kJointPosition;
}

template <class Vector>
Joints seven(const Vector& values) {
  return values.size() == kJoints ? Joints(values) : Joints::Zero();
}

Eigen::Matrix<double, 6, 1> flat(const net::Wrench& wrench) {
  Eigen::Matrix<double, 6, 1> all;
  all << wrench.force, wrench.torque;
  return all;
}

}  // namespace

Controller::Controller(std::shared_ptr<const device::ArmDescription> arm, const ControllerOptions& options)
    : arm_(std::move(arm)),
      options_(options),
      cycle_(to_seconds(options.cycle)),
      program_(make_krl_program(options.krl)),
      window_(options.quality),
      sequence_(options.first_sequence),
      interpolator_(cycle_) {
  news_.reserve(kMostNews);
}

// -- Answers
// -----------------------------------------------------------------------------------------------------------

void Controller::take(const Command& command, Nanoseconds now) {
  const auto age = static_cast<std::uint16_t>(sequence_ - 1 - command.reflected);
  // An answer counts until the second next datagram is due; for control only the one to the last datagram does.
  Sent& sent = sent_[command.reflected % sent_.size()];
  const bool counts = age < 2 && sent.time >= 0 && !sent.answered;
  if (!counts) {
    ++stale_;
    return;
  }
  sent.answered = true;
  sent.round_trip = now - sent.time;
  if (age == 1 && has_command_) return;  // overtaken by a newer one
  command_ = command;
  has_command_ = age == 0;
}

void Controller::judge_answers() {
  const Sent& sent = sent_[static_cast<std::uint16_t>(sequence_ - 2) % sent_.size()];
  if (sent.time >= 0) window_.add(sent.answered, sent.round_trip);
}

// -- The cycle
// ---------------------------------------------------------------------------------------------------------

void Controller::begin_cycle(Nanoseconds now, const device::ArmSample& machine) {
  begun_ = now;
  look_at_machine(machine);
  if (standing_) {
    ++held_cycles_;
    judge_answers();
    poll_krl(now);
    if (start_cycles_left_ > 0) try_to_start();
    if (stopping_) {
      continue_stop();
    } else if (state_ == State::kCommand && power_) {
      follow_command();
    }
  }
  fill_measurement(now, machine);
  if (state_ == State::kOff) return;
  sent_[sequence_ % sent_.size()] = {.time = now};
  ++sequence_;
  has_command_ = false;
}

/// Drives that are not ready do not follow: where they let the arm go, it is. Position control begins where it is, too.
void Controller::look_at_machine(const device::ArmSample& machine) {
  const bool begins_position = machine.mode != machine_.mode && machine.mode == ControlMode::kPosition;
  machine_ = machine;
  if (standing_ && !machine.ready) {
    if (state_ == State::kCommand) fall_back(net::Text("drives are off"));
    standing_ = stopping_ = false;
  }
  if ((standing_ && !begins_position) || !machine.ready || machine.q.size() != kJoints) return;
  stand(machine.commanded.size() == kJoints ? Joints(machine.commanded) : Joints(machine.q));
  standing_ = true;
}

void Controller::poll_krl(Nanoseconds now) {
  if (now < next_poll_) return;
  next_poll_ = now + kKrlCycle;
  program_->poll(*this);
}

motion::JointSample Controller::at(Nanoseconds now) const {
  return stopping_ ? ramp_.sample(to_seconds(now - ramp_begin_)) : interpolator_.at(to_seconds(now - begun_));
}

device::ControlMode Controller::mode() const { return mode_of(control_); }

// -- KRL
// ---------------------------------------------------------------------------------------------------------------

bool Controller::set_strategy(int strategy) {
  const Control control = control_of(strategy);
  if (state_ != State::kMonitor || control == Control::kOther || !arm_->modes.has(mode_of(control))) return false;
  control_ = control;
  compliance_ = arm_->impedance.standard(mode_of(control));
  compliance_.in_tool_axes = options_.task_frame_is_tool;
  return true;
}

void Controller::fri_start(double safety_limits) {
  if (state_ != State::kMonitor) return;
  safety_limits_ = std::clamp(safety_limits, 0.0, 1.0);
  start_cycles_left_ = static_cast<int>(kStartTimeout / options_.cycle);
}

void Controller::fri_stop() {
  start_cycles_left_ = 0;
  if (state_ != State::kCommand) return;
  enter(State::kMonitor, "friStop");
  stop_motion();
}

void Controller::fri_close() {
  fri_stop();
  enter(State::kOff, "friClose");
}

void Controller::enter(State state, std::string_view why) {
  state_ = state;
  power_ = false;
  if (news_.size() < kMostNews) news_.push_back(fmt::format("{}: {}", name_of(state), why));
}

bool Controller::machine_is_in_mode() const {
  return machine_.ready && machine_.mode == mode() && !machine_.changing_mode;
}

/// State command begins when the remote side answers well enough and commands what the arm does already.
void Controller::try_to_start() {
  if (--start_cycles_left_ == 0) return fall_back(net::Text("friStart was given up: no good answers in time"));
  // The remote side can only mirror what it was told before: not where the arm has begun to be held in this cycle.
  if (stopping_ || held_cycles_ < kMirrorCycles || !machine_is_in_mode()) return;
  // It goes on until the quality is unacceptable. What begins with less than ok has nothing in reserve.
  if (window_.quality() < Quality::kOk || !has_command_) return;
  start_cycles_left_ = 0;
  if (const auto mismatch = start_mismatch()) {
    return fall_back(net::format_text("FRI interpolation error: {}", mismatch->view()));
  }
  enter(State::kCommand, name_of(control_));
  power_ = true;
  interpolator_.start_from(*commanded_joints());
}

bool Controller::commands_position() const { return (command_.flags & position_flag(control_)) != 0; }

std::optional<net::Text> Controller::start_mismatch() const {
  if (const auto wrong = wrong_command()) return wrong;
  const auto q = commanded_joints();
  if (!q) return net::Text("the pose cannot be reached");
  for (int i = 0; i < kJoints; ++i) {
    const double step = std::abs((*q)[i] - commanded()[i]);
    if (!(step <= options_.start_tolerance)) return net::format_text("joint {} commanded {:.4f} rad off", i + 1, step);
  }
  return std::nullopt;
}

// -- Command state
// -----------------------------------------------------------------------------------------------------

/// Joints of a Cartesian command: the solution on the branch where the arm is, with the third joint as commanded.
/// What the flags leave out is as KRL has it: its own position, which it holds.
std::optional<Joints> Controller::commanded_joints() const {
  const bool with_posture = (command_.flags & kJointPosition) != 0;
  if (control_ != Control::kCartesianImpedance) return commands_position() ? command_.q : before_fri_;
  if (!commands_position() && !with_posture) return before_fri_;
  if (commands_position() && !command_.X_BT.matrix().allFinite()) return std::nullopt;
  if (!arm_->inverse) return with_posture ? std::optional(command_.q) : std::nullopt;
  kinematics::JointVector q = interpolator_.end();
  const kinematics::JointVector wanted = with_posture ? command_.q : Joints(q);
  const Eigen::Isometry3d X_BF =
      commands_position() ? command_.X_BT * tool_.X_FT.inverse() : arm_->chain->forward(before_fri_);
  // A command that gives both is meant as it is given: binary32 leaves 1e-6 m between them.
  const kinematics::Vector6 apart = kinematics::pose_error(arm_->chain->forward(wanted), X_BF);
  if (with_posture && apart.cwiseAbs().maxCoeff() < 1e-5) return Joints(wanted);
  if (arm_->inverse->solve(X_BF, arm_->inverse->held(wanted), q) != kinematics::IkStatus::kOk) return std::nullopt;
  return Joints(q);
}

/// In impedance a client may command torques or wrenches alone.
std::optional<net::Text> Controller::wrong_command() const {
  if (control_ == Control::kPosition && !commands_position()) return net::Text("no position is commanded");
  const bool with_joints = (command_.flags & kJointPosition) != 0;
  if (with_joints && !command_.q.allFinite()) return net::Text("a commanded position is not finite");
  return std::nullopt;
}

void Controller::follow_command() {
  if (window_.quality() == Quality::kUnacceptable) return fall_back(net::Text("communication quality unacceptable"));
  if (!has_command_) return bridge_gap();
  if (const auto wrong = wrong_command()) return fall_back(*wrong);
  const auto q = commanded_joints();
  if (!q) return fall_back(net::Text("the commanded pose cannot be reached"));
  if (const auto wrong = take_compliance()) return fall_back(*wrong);
  Interpolator next = interpolator_;
  next.go(*q);
  if (const auto wrong = wrong_motion(next)) return fall_back(*wrong);
  interpolator_ = next;
}

void Controller::bridge_gap() {
  if (interpolator_.missing() + 1 >= options_.bridged)
    return fall_back(net::format_text("{} answers missing in a row", options_.bridged));
  interpolator_.bridge();
}

/// A compliant arm is drawn by a spring to the position that is commanded, and clients command the one that was
/// measured: what pushes the arm, and the noise of two differences, makes accelerations that are no command's.
std::optional<net::Text> Controller::wrong_motion(const Interpolator& next) const {
  const bool compliant = control_ != Control::kPosition;
  const motion::JointLimits& limits = arm_->limits;
  const Joints v = next.velocity(), a = next.acceleration(), q = next.end();
  const auto name = [&](int i) { return std::string_view(arm_->joint_names[static_cast<std::size_t>(i)]); };
  for (int i = 0; i < kJoints; ++i) {
    const double fastest = options_.velocity_factor * limits.velocity[i];
    const double hardest = safety_limits_ * options_.acceleration[i];
    if (!(q[i] >= limits.lower[i] && q[i] <= limits.upper[i]))
      return net::format_text("joint {}: {:.4f} rad is out of range", name(i), q[i]);
    if (!(std::abs(v[i]) <= fastest))
      return net::format_text("joint {}: {:.3f} rad/s beyond {:.3f}", name(i), v[i], fastest);
    if (!compliant && !(std::abs(a[i]) <= hardest))
      return net::format_text("joint {}: {:.1f} rad/s^2 beyond {:.1f}", name(i), a[i], hardest);
  }
  return std::nullopt;
}

/// What the flags leave out is as KRL has it.
std::optional<net::Text> Controller::take_compliance() {
  if (control_ == Control::kPosition) return std::nullopt;
  const device::ComplianceRange& range = arm_->impedance.range(mode());
  device::Compliance next = range.standard;
  next.in_tool_axes = compliance_.in_tool_axes;
  const bool joints = control_ == Control::kJointImpedance;
  const std::uint32_t flags = command_.flags;
  if (flags & (joints ? kJointStiffness : kCartesianStiffness))
    next.stiffness =
        joints ? device::JointVector(command_.stiffness) : device::JointVector(command_.cartesian_stiffness);
  if (flags & (joints ? kJointDamping : kCartesianDamping))
    next.damping_ratio =
        joints ? device::JointVector(command_.damping) : device::JointVector(command_.cartesian_damping);
  if (flags & (joints ? kJointTorque : kCartesianWrench))
    next.feed_forward = joints ? device::JointVector(command_.tau) : device::JointVector(flat(command_.wrench));
  // Clients command no damping at all where they want torques only: then the arm damps as little as it can.
  for (Eigen::Index i = 0; i < next.damping_ratio.size(); ++i)
    if (next.damping_ratio[i] >= 0.0)
      next.damping_ratio[i] = std::max(next.damping_ratio[i], range.lower.damping_ratio[i]);
  if (const auto wrong = device::find_fault(next, next, range, 1.0)) return wrong;
  compliance_ = next;
  return std::nullopt;
}

// -- Stops
// -------------------------------------------------------------------------------------------------------------

void Controller::fall_back(const net::Text& why) {
  if (state_ == State::kCommand) ++fallbacks_;
  enter(State::kMonitor, why.view());
  stop_motion();
}

/// Brakes within the limits from where the arm is told to be now: at the end of the last cycle. What a remote side asks
/// for may be harder than the model allows; drives that brake do not first bring that down within its jerk.
void Controller::stop_motion() {
  motion::JointSample from = interpolator_.at(cycle_);
  const auto& hardest = arm_->limits.acceleration;
  for (int i = 0; i < kJoints; ++i) from.ddq[i] = std::clamp(from.ddq[i], -hardest[i], hardest[i]);
  ramp_ = device::BrakeRamp(from, arm_->limits);
  ramp_begin_ = begun_;
  stopping_ = true;
  compliance_.feed_forward.setZero();
}

void Controller::continue_stop() {
  const double time = to_seconds(begun_ - ramp_begin_);
  const Joints q = ramp_.sample(time).q;
  if (time < ramp_.duration()) return;
  stopping_ = false;
  stand(q);
}

void Controller::stand(const Joints& q) {
  interpolator_.stand(q);
  before_fri_ = as_on_wire(q);
  held_cycles_ = 0;
}

// -- What is sent
// ------------------------------------------------------------------------------------------------------

void Controller::fill_measurement(Nanoseconds now, const device::ArmSample& machine) {
  Measurement& m = measurement_;
  m.sequence = sequence_;
  m.reflected = command_.sequence;
  m.krl = to_remote_;
  m.timestamp = to_seconds(now);
  m.state = state_;
  m.quality = window_.quality();
  m.measurement_period = m.command_period = cycle_;
  m.safety_limits = safety_limits_;
  m.statistics = window_.statistics();
  m.power = power_ && machine.ready ? kAllDrives : 0;
  m.control = control_;
  m.error = machine.fault != 0 ? 1 : 0;
  m.q = seven(machine.q);
  // While the arm stops by itself it is the controller that moves it.
  const Joints told = stopping_ ? Joints(at(now).q) : commanded();
  if (stopping_) before_fri_ = as_on_wire(told);
  m.q_before = before_fri_;
  m.q_offset = told - before_fri_;
  m.tau = seven(machine.tau);
  m.tau_external = seven(machine.tau_external);
  if (arm_->chain) fill_dynamics(told);
}

void Controller::fill_dynamics(const Joints& told) {
  Measurement& m = measurement_;
  Eigen::Isometry3d X_BF;
  kinematics::Jacobian J;
  arm_->chain->jacobian(m.q, X_BF, J);
  m.X_BT = X_BF * tool_.X_FT;
  // From the flange to the tool, and into the axes of the task frame.
  const Eigen::Vector3d p_FT_B = m.X_BT.translation() - X_BF.translation();
  const Eigen::Matrix3d R =
      options_.task_frame_is_tool ? m.X_BT.linear().transpose().eval() : Eigen::Matrix3d::Identity();
  for (int i = 0; i < kJoints; ++i) {
    const Eigen::Vector3d w = J.col(i).tail<3>(), v = J.col(i).head<3>() + w.cross(p_FT_B);
    m.jacobian.col(i) << R * v, R * w;
  }
  const Eigen::Matrix<double, 6, 6> JJ =
      m.jacobian * m.jacobian.transpose() + 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
  const Axes wrench = JJ.ldlt().solve(m.jacobian * m.tau_external);
  m.wrench_external = {wrench.head<3>(), wrench.tail<3>()};
  const kinematics::Payload payload{tool_.payload.mass, tool_.payload.p_FC, tool_.payload.I_C};
  m.mass = arm_->chain->mass_matrix(m.q, payload);
  const kinematics::JointVector rest = kinematics::JointVector::Zero(kJoints);
  m.gravity = arm_->chain->inverse_dynamics(m.q, rest, rest, {0.0, 0.0, -9.81}, payload);
  m.X_BT_before = arm_->chain->forward(before_fri_) * tool_.X_FT;
  m.X_offset = m.X_BT_before.inverse() * arm_->chain->forward(told) * tool_.X_FT;
}

std::vector<std::string> Controller::news() {
  std::vector<std::string> news;
  news.reserve(kMostNews);
  std::swap(news, news_);
  return news;
}

}  // namespace takt::hw::fri
