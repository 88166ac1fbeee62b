#include "hw/fri/client.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "hw/fri/protocol/krl_words.h"

namespace takt::hw::fri {
namespace {

using device::ControlMode;

constexpr std::int64_t kFarAhead = 1000;     // cycles: a number that far on belongs to another session
constexpr Nanoseconds kForgotten = kSecond;  // after which another port may speak for the controller
constexpr double kSameOnWire = 5e-7;         // rad: what two roundings to binary32 leave of pi
constexpr double kFastGap = 20;              // cycles: over more than that no velocity is formed

Control control_of(ControlMode mode) {
  if (mode == ControlMode::kJointImpedance) return Control::kJointImpedance;
  return mode == ControlMode::kCartesianImpedance ? Control::kCartesianImpedance : Control::kPosition;
}

ControlMode mode_of(Control control) {
  if (control == Control::kJointImpedance) return ControlMode::kJointImpedance;
  return control == Control::kCartesianImpedance ? ControlMode::kCartesianImpedance : ControlMode::kPosition;
}

std::uint32_t flags_of(Control control) {
  if (control == Control::kJointImpedance) return kJointImpedanceFlags;
  return control == Control::kCartesianImpedance ? kCartesianImpedanceFlags : kPositionFlags;
}

bool same_for_all_axes(const device::JointVector& values) {
  const auto equal = [&](Eigen::Index from) {
    return values.segment(from, 3).maxCoeff() == values.segment(from, 3).minCoeff();
  };
  return values.size() == 6 && equal(0) && equal(3);
}

}  // namespace

Client::Client(const device::DriverRequest& request, const ClientOptions& options, std::unique_ptr<DatagramLink> link,
               const Clock& clock)
    : arm_(request.description),
      options_(options),
      link_(std::move(link)),
      clock_(clock),
      agent_(arm_->limits, options.timing(request.core_period, request.padding), clock),
      force_agent_(clock, options.cycle, options.margin, options.timing(request.core_period, 0).sequence_bits),
      handshake_(make_krl_handshake(options.krl)),
      supervisor_(options.cycle) {}

std::string Client::fault_text(std::uint32_t fault) {
  const std::string agents = device::ArmAgent::fault_text(fault);
  return agents.empty() ? std::string(text_of(static_cast<Fault>(fault))) : agents;
}

// -- The core's side
// ---------------------------------------------------------------------------------------------------

bool Client::read(device::ArmSample& sample) {
  const bool any = agent_.read(sample);
  // On the way to another control mode the interface is in monitor state, as was asked for: the arm is not lost.
  if (sample.changing_mode && sample.fault == 0) sample.ready = true;
  const bool silent = clock_.now() - sample.stamp > device::DeviceSession::kBridged * options_.cycle;
  if (any && silent && sample.fault == 0) sample.fault = device::ArmAgent::kSilent;
  return any;
}

void Client::write_compliance(const device::Compliance& compliance) {
  core_settings_.compliance = compliance;
  settings_.publish(core_settings_);
}

void Client::set_tool(const device::ToolSetting& tool) {
  core_settings_.X_FT = tool.X_FT;
  settings_.publish(core_settings_);
}

void Client::change_mode(ControlMode mode) {
  core_settings_.compliance = arm_->impedance.standard(mode);
  settings_.publish(core_settings_);
  const std::uint32_t request = ++mode_requests_ << 8 | static_cast<std::uint32_t>(mode);
  wanted_mode_.store(request, std::memory_order_release);
}

// -- The device's side
// -------------------------------------------------------------------------------------------------

void Client::serve() {
  while (const auto received = link_->receive(buffer_)) {
    if (received->size > buffer_.size() || is_stranger(received->from)) {
      ++report_.strangers;
      continue;
    }
    take(std::span(buffer_).first(received->size), received->from);
  }
  // Without a measurement nothing else says what came.
  if (!seen_.any && report_.strangers + report_.misread > 0) published_.publish(report_);
}

void Client::discard() {
  while (link_->receive(buffer_)) continue;
}

/// The port from which the controller speaks may change, but not while it does.
bool Client::is_stranger(const Endpoint& from) {
  if (options_.controller != 0 && from.host != options_.controller) return true;
  const bool silent = clock_.read().machine - heard_ > kForgotten;
  return seen_.any && !silent && from != controller_;
}

void Client::take(std::span<const std::byte> datagram, const Endpoint& from) {
  const auto m = decode_measurement(datagram);
  if (!m) {
    ++report_.misread;
    return;
  }
  controller_ = from;
  heard_ = clock_.read().machine;
  answer(*m);
}

/// Of what came before; not above 0: older, repeated.
std::int64_t Client::ahead(const Measurement& m) const {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(m.sequence - seen_.sequence));
}

void Client::answer(const Measurement& m) {
  (void)settings_.take();
  const std::int64_t step = seen_.any ? ahead(m) : 1;
  const bool plausible = step > 0 && step < kFarAhead;
  if (plausible) {
    take_requests();
    supervisor_.look(m, heard_, *handshake_);
    if (!fits_task_frame(settings_.value().compliance)) supervisor_.refuse(Fault::kTaskFrame);
  }
  const device::ArmPacket measured = packet(m, step);
  take_wrench(m, measured.instant);
  const auto answer = agent_.answer(measured);
  if (!answer && !plausible) {
    ++report_.old;
    return;
  }
  if (!plausible) supervisor_.look(m, heard_, *handshake_);  // a new session
  if (answer && answer->brake) brake_by_ramp();
  seen_ = {m.sequence, seen_.cycle + step, m.q, measured.sample.dq, true};
  fill_command(m, next_position(m, answer));
  send();
  publish(m);
}

void Client::take_requests() {
  const int resets = resets_.load(std::memory_order_acquire);
  if (resets != resets_seen_) supervisor_.reset(heard_);
  resets_seen_ = resets;
  const std::uint32_t mode = wanted_mode_.load(std::memory_order_acquire);
  if (mode != mode_seen_) supervisor_.change(control_of(static_cast<ControlMode>(mode & 0xff)), heard_);
  mode_seen_ = mode;
  if (leaving_) supervisor_.stop();
}

Joints Client::velocity(const Measurement& m, std::int64_t step) const {
  if (!seen_.any || step < 1 || step > kFastGap) return seen_.dq;
  return (m.q - seen_.q) / (static_cast<double>(step) * to_seconds(options_.cycle));
}

/// Where the drives are told to be. The interface keeps binary32: where that is what was commanded last, it is that.
Joints Client::held(const Measurement& m) const {
  Joints q = m.q_before + m.q_offset;
  const Joints& last = answered_;
  for (int i = 0; i < kJoints; ++i)
    if (std::abs(q[i] - last[i]) < kSameOnWire) q[i] = last[i];
  return q;
}

device::ArmPacket Client::packet(const Measurement& m, std::int64_t step) const {
  device::ArmPacket packet;
  device::ArmSample& sample = packet.sample;
  // The time stamp on the wire is too coarse to measure by: the number is the time.
  packet.instant = (seen_.cycle + step) * options_.cycle;
  sample.sequence = m.sequence;
  sample.stamp = packet.instant;
  sample.q = m.q;
  sample.dq = velocity(m, step);
  sample.tau = m.tau;
  sample.tau_external = m.tau_external;
  sample.commanded = held(m);
  sample.mode = mode_of(m.control);
  sample.changing_mode = supervisor_.changing();
  sample.braked = !drives_on(m);
  const Fault fault = supervisor_.fault(m);
  sample.ready = fault == Fault::kNone && !supervisor_.changing();
  sample.fault = supervisor_.changing() ? 0 : static_cast<std::uint32_t>(fault);
  return packet;
}

/// The controller's wrench is about the tool centre point that was entered there, in axes of $STIFFNESS.TASKFRAME.
void Client::take_wrench(const Measurement& m, Nanoseconds instant) {
  if (!arm_->chain) return;
  const Eigen::Isometry3d X_BF = arm_->chain->forward(m.q);
  const Eigen::Matrix3d R_FB = X_BF.linear().transpose();
  const Eigen::Matrix3d R_FW = options_.task_frame_is_tool ? Eigen::Matrix3d(R_FB * m.X_BT.linear()) : R_FB;
  const Eigen::Vector3d p_FT_F = R_FB * (m.X_BT.translation() - X_BF.translation());
  device::WrenchSample sample{.sequence = m.sequence, .stamp = instant, .wrench = {}};
  sample.wrench.force = R_FW * m.wrench_external.force;
  sample.wrench.torque = R_FW * m.wrench_external.torque + p_FT_F.cross(sample.wrench.force);
  force_agent_.take(sample, instant);
}

/// While it may not be moved the arm is told to be where it is told to be: command state begins without a step.
Joints Client::next_position(const Measurement& m, const std::optional<device::ArmAnswer>& answer) {
  const bool commands = m.state == State::kCommand && drives_on(m);
  if (commands && ramp_begin_ >= 0)
    return ramp_.sample(static_cast<double>(seen_.cycle - ramp_begin_) * to_seconds(options_.cycle)).q;
  ramp_begin_ = -1;
  if (!answer || !commands || supervisor_.fault(m) != Fault::kNone) {
    last_state_ = {};
    return held(m);
  }
  last_state_ = answer->state;
  return answer->state.q;
}

/// FRI cannot close brakes: KRL does so on the request to stop, which takes some of its cycles.
void Client::brake_by_ramp() {
  if (ramp_begin_ < 0 && last_state_.q.size() == kJoints) {
    ramp_ = device::BrakeRamp(last_state_, arm_->limits);
    ramp_begin_ = seen_.cycle;
  }
  supervisor_.stop();
}

bool Client::fits_task_frame(const device::Compliance& compliance) const {
  const bool cartesian = compliance.mode == ControlMode::kCartesianImpedance;
  if (!cartesian || compliance.in_tool_axes == options_.task_frame_is_tool) return true;
  return same_for_all_axes(compliance.stiffness) && same_for_all_axes(compliance.damping_ratio);
}

void Client::fill_command(const Measurement& m, const Joints& q) {
  ++command_.sequence;
  command_.reflected = m.sequence;
  handshake_->fill(supervisor_.request(), m, command_.krl);
  command_.flags = flags_of(supervisor_.request().control);
  command_.q = q;
  answered_ = q;
  if (arm_->chain) command_.X_BT = arm_->chain->forward(q) * settings_.value().X_FT;
  fill_compliance();
}

void Client::fill_compliance() {
  const device::Compliance& compliance = settings_.value().compliance;
  if (compliance.mode == ControlMode::kJointImpedance && compliance.stiffness.size() == kJoints) {
    command_.stiffness = compliance.stiffness;
    command_.damping = compliance.damping_ratio;
    command_.tau = compliance.feed_forward;
  } else if (compliance.mode == ControlMode::kCartesianImpedance && compliance.stiffness.size() == 6) {
    command_.cartesian_stiffness = compliance.stiffness;
    command_.cartesian_damping = compliance.damping_ratio;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // from the axes of the compliance to those of the task frame
    if (compliance.in_tool_axes != options_.task_frame_is_tool) R = command_.X_BT.linear();
    if (!compliance.in_tool_axes && options_.task_frame_is_tool) R.transposeInPlace();
    command_.wrench = {R * compliance.feed_forward.head<3>(), R * compliance.feed_forward.tail<3>()};
  }
}

void Client::send() {
  encode(command_, std::span(buffer_).first<kCommandSize>());
  ++(link_->send(std::span(buffer_).first(kCommandSize), controller_) ? report_.answers : report_.unsent);
}

void Client::publish(const Measurement& m) {
  ++report_.measurements;
  report_.state = m.state;
  report_.quality = m.quality;
  report_.statistics = m.statistics;
  report_.fault = supervisor_.fault(m);
  report_.power = m.power;
  report_.error = m.error;
  report_.warning = m.warning;
  report_.hottest = m.temperature.maxCoeff();
  published_.publish(report_);
}

bool Client::leave() {
  leaving_ = true;
  serve();
  const bool silent = clock_.read().machine - heard_ > kForgotten / 4;
  return !seen_.any || silent || report_.state != State::kCommand;
}

// -- News
// --------------------------------------------------------------------------------------------------------------

std::string Client::refusal() {
  (void)published_.take();
  const ClientReport& now = published_.value();
  if (now.measurements > 0) return {};
  if (now.misread > 0)
    return fmt::format("{} datagrams came that are no measurements of FRI 1.0: take the version of FRI that fits",
                       now.misread);
  if (now.strangers > 0)
    return fmt::format("{} datagrams came, none from the controller: give the address that it sends from",
                       now.strangers);
  return {};
}

std::vector<std::string> Client::news() {
  std::vector<std::string> lines;
  (void)published_.take();
  const ClientReport& now = published_.value();
  const auto worse = [](Quality a, Quality b) { return a <= Quality::kBad || b <= Quality::kBad; };
  const bool quality_changed = now.quality != told_.quality && worse(now.quality, told_.quality);
  const bool any = now.measurements > 0;
  if (any && (now.state != told_.state || quality_changed || told_.measurements == 0))
    lines.push_back(fmt::format("FRI state {}, quality {}", name_of(now.state), name_of(now.quality)));
  if (now.fault != told_.fault && now.fault != Fault::kNone) lines.emplace_back(text_of(now.fault));
  if (now.error != told_.error && now.error != 0) lines.push_back(fmt::format("drive errors {:#06x}", now.error));
  if (now.warning != told_.warning && now.warning != 0)
    lines.push_back(fmt::format("drive warnings {:#06x}", now.warning));
  if (now.strangers > told_.strangers)
    lines.push_back(fmt::format("{} datagrams of strangers dropped", now.strangers - told_.strangers));
  if (now.misread > told_.misread)
    lines.push_back(fmt::format("{} datagrams of another length or version dropped", now.misread - told_.misread));
  told_ = now;
  return lines;
}

}  // namespace takt::hw::fri
