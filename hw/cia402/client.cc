#include "hw/cia402/client.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "hw/cia402/protocol/objects.h"

namespace takt::hw::cia402 {
namespace {

constexpr std::uint32_t kDriveFault = 0x4100'0000, kDriveFaultMask = 0xFFF0'0000;

const char* text_of(ClientFault fault) {
  switch (fault) {
    case ClientFault::kNone:
      return "";
    case ClientFault::kNotEnabled:
      return "its drives are not in 'operation enabled'";
    case ClientFault::kStopped:
      return "a drive left 'operation enabled'; reset, or run again";
    case ClientFault::kSwitchedOff:
      return "its drives were switched off; reset, or run again";
    case ClientFault::kOtherMode:
      return "a drive is in another mode of operation than CSP";
  }
  return "an unknown fault";
}

std::int32_t increments(double value) {
  return static_cast<std::int32_t>(std::llround(std::clamp(value, -2147483648.0, 2147483647.0)));
}

}  // namespace

Client::Client(const device::DriverRequest& request, const ClientOptions& options, std::unique_ptr<FieldBus> bus,
               const Clock& clock)
    : arm_(request.description),
      options_(options),
      bus_(std::move(bus)),
      clock_(clock),
      agent_(arm_->limits, options.timing(request.core_period, request.padding), clock),
      axes_(static_cast<std::size_t>(arm_->limits.velocity.size())),
      outputs_(axes_.size()) {
  const Eigen::Index count = arm_->limits.velocity.size();
  last_ = {device::JointVector::Zero(count), device::JointVector::Zero(count), device::JointVector::Zero(count)};
}

std::string Client::fault_text(std::uint32_t fault) const {
  if (std::string agents = device::ArmAgent::fault_text(fault); !agents.empty()) return agents;
  if ((fault & kDriveFaultMask) != kDriveFault) return text_of(static_cast<ClientFault>(fault));
  const std::size_t joint = fault >> 16 & 0xF;
  const auto code = static_cast<std::uint16_t>(fault);
  const std::string name = joint < arm_->joint_names.size() ? arm_->joint_names[joint] : "?";
  return fmt::format("the drive of joint {}: {} ({:04X}h)", name, text_of_error(code), code);
}

bool Client::read(device::ArmSample& sample) {
  const bool any = agent_.read(sample);
  const bool silent = clock_.now() - sample.stamp > device::DeviceSession::kBridged * options_.cycle;
  if (any && silent && sample.fault == 0) sample.fault = device::ArmAgent::kSilent;
  return any;
}

// -- The device's side
// -------------------------------------------------------------------------------------------------

void Client::begin_cycle() {
  ++cycle_;
  bus_->begin_cycle(clock_.read().machine);
}

void Client::poll() {
  const bool complete = bus_->poll(clock_.read().machine);
  collect_lines();
  if (enabled_ && bus_->phase() != FieldBus::Phase::kRunning) {
    enabled_ = false;
    stop(static_cast<std::uint32_t>(ClientFault::kStopped));
  }
  if (complete) answer();
}

void Client::take_requests() {
  const int resets = resets_.load(std::memory_order_acquire);
  if (std::exchange(resets_seen_, resets) == resets || leaving_) return;
  stopped_ = off_ = false;
  may_reset_ = true;
}

void Client::answer() {
  take_requests();
  take_states();
  const auto answer = agent_.answer(packet());
  if (answer && answer->brake) {
    stop(static_cast<std::uint32_t>(ClientFault::kSwitchedOff));
    off_ = true;
  }
  send(next_set_point(answer));
}

void Client::take_states() {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    Axis& axis = axes_[i];
    axis.state = state_of(bus_->inputs(i).status);
    // One that moves nothing is told to be where it is: it is enabled without a step.
    if (axis.state != DriveState::kOperationEnabled)
      axis.held = bus_->inputs(i).position / bus_->data(i).increments_per_rad;
  }
  const bool was_enabled = std::exchange(enabled_, all_enabled());
  if (was_enabled && !enabled_) stop(cause());
  // A drive may say later than it stops why it does.
  if (fault_ == static_cast<std::uint32_t>(ClientFault::kStopped)) fault_ = cause();
  if (enabled_) may_reset_ = false;
}

bool Client::all_enabled() const {
  return std::ranges::all_of(axes_, [](const Axis& axis) { return axis.state == DriveState::kOperationEnabled; });
}

/// What a person has to look at: the first error of a drive.
std::uint32_t Client::cause() const {
  for (std::size_t i = 0; i < axes_.size(); ++i)
    if (bus_->error(i) != 0) return drive_fault(i, bus_->error(i));
  return static_cast<std::uint32_t>(ClientFault::kStopped);
}

void Client::stop(std::uint32_t fault) {
  if (std::exchange(stopped_, true)) return;
  fault_ = fault;
}

Wanted Client::wanted() const {
  if (off_) return Wanted::kOff;
  return stopped_ || leaving_ ? Wanted::kQuickStop : Wanted::kOn;
}

device::ArmPacket Client::packet() const {
  const auto count = static_cast<Eigen::Index>(axes_.size());
  device::ArmPacket packet;
  packet.instant = cycle_ * options_.cycle;
  device::ArmSample& sample = packet.sample;
  sample.sequence = static_cast<std::uint64_t>(cycle_) + 1;
  sample.stamp = packet.instant;
  sample.q.resize(count);
  sample.dq.resize(count);
  sample.tau.resize(count);
  bool position_mode = true;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    const DriveInputs& inputs = bus_->inputs(i);
    const DriveData& data = bus_->data(i);
    sample.q[j] = inputs.position / data.increments_per_rad;
    sample.dq[j] = inputs.velocity / data.increments_per_rad;
    sample.tau[j] = inputs.torque * data.torque_unit;
    position_mode = position_mode && inputs.mode == kCyclicPosition;
  }
  sample.commanded = told_now();
  sample.braked = std::ranges::none_of(axes_, [](const Axis& axis) {
    return axis.state == DriveState::kOperationEnabled || axis.state == DriveState::kQuickStopActive;
  });
  sample.ready = enabled_ && !stopped_ && !leaving_ && position_mode;
  if (stopped_) {
    sample.fault = fault_;
  } else if (!sample.ready) {
    sample.fault = static_cast<std::uint32_t>(enabled_ ? ClientFault::kOtherMode : ClientFault::kNotEnabled);
  }
  return packet;
}

/// At the instant of this cycle.
device::JointVector Client::told_now() const {
  const ReportedState& told = told_[static_cast<std::size_t>(cycle_) % told_.size()];
  if (enabled_ && told.cycle == cycle_) return told.q;
  device::JointVector held(static_cast<Eigen::Index>(axes_.size()));
  for (std::size_t i = 0; i < axes_.size(); ++i) held[static_cast<Eigen::Index>(i)] = axes_[i].held;
  return held;
}

/// The agent's while it answers and the drives follow. What moves without an answer is braked.
motion::JointSample Client::next_set_point(const std::optional<device::ArmAnswer>& answer) {
  const auto zero = device::JointVector::Zero(last_.q.size());
  if (!enabled_ || stopped_) {
    ramp_.reset();
    following_ = false;
    device::JointVector held(last_.q.size());
    for (std::size_t i = 0; i < axes_.size(); ++i) held[static_cast<Eigen::Index>(i)] = axes_[i].held;
    return {held, zero, zero};
  }
  if (answer) {
    ramp_.reset();
    following_ = true;
    return answer->state;
  }
  if (!ramp_ && following_) {
    ramp_ = device::BrakeRamp(last_, arm_->limits);
    ramp_begin_ = cycle_ - 1;
  }
  if (!ramp_) return {last_.q, zero, zero};
  return ramp_->sample(to_seconds((cycle_ - ramp_begin_) * options_.cycle));
}

std::uint16_t Client::control(const Axis& axis) const {
  const bool fault = axis.state == DriveState::kFault;
  // A rising edge takes an error back.
  if (fault && may_reset_ && !stopped_ && !leaving_)
    return (axis.outputs.control & kFaultReset) != 0 ? kDisableVoltage : kFaultReset;
  return control_for(wanted(), axis.state);
}

void Client::send(const motion::JointSample& set_point) {
  last_ = set_point;
  told_[static_cast<std::size_t>(cycle_ + kLeadCycles) % told_.size()] = {cycle_ + kLeadCycles, set_point.q};
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    Axis& axis = axes_[i];
    const auto j = static_cast<Eigen::Index>(i);
    const double scale = bus_->data(i).increments_per_rad;
    if (enabled_) axis.held = set_point.q[j];
    axis.outputs.control = control(axis);
    axis.outputs.target = increments(set_point.q[j] * scale);
    axis.outputs.velocity = increments(set_point.dq[j] * scale);
    outputs_[i] = axis.outputs;
  }
  bus_->send(outputs_);
}

bool Client::leave() {
  leaving_ = true;
  const auto moved = [](const Axis& axis) {
    return axis.state == DriveState::kOperationEnabled || axis.state == DriveState::kQuickStopActive;
  };
  return bus_->phase() != FieldBus::Phase::kRunning || std::ranges::none_of(axes_, moved);
}

void Client::collect_lines() {
  std::vector<std::string> lines = bus_->lines();
  if (lines.empty()) return;
  const std::scoped_lock lock(lines_mutex_);
  refusal_ = bus_->refusal();
  std::ranges::move(lines, std::back_inserter(lines_));
}

std::string Client::refusal() const {
  const std::scoped_lock lock(lines_mutex_);
  return refusal_;
}

std::vector<std::string> Client::news() {
  const std::scoped_lock lock(lines_mutex_);
  return std::exchange(lines_, {});
}

void Client::add_state(emulation::StateHash& hash) const {
  hash.add(cycle_);
  hash.add(last_.q);
  hash.add(last_.dq);
  hash.add(std::int64_t{enabled_} | std::int64_t{stopped_} << 1 | std::int64_t{off_} << 2 | std::int64_t{fault_} << 8);
  hash.add(agent_.resampled_time());
}

}  // namespace takt::hw::cia402
