#include "core/device/arm_agent.h"

#include <algorithm>
#include <cmath>

namespace takt::device {

namespace {

// The core takes an arm over where it was told to be, bit for bit; what differs more than by rounding is a step.
constexpr double kSamePlace = 1e-9;  // rad or m

bool begins_at(const ArmSetPoint& first, const JointVector& q) {
  return first.q.size() == q.size() && (first.q - q).cwiseAbs().maxCoeff() <= kSamePlace && first.dq.isZero(kSamePlace);
}

/// What has another size is left out, so that the set points run out.
bool has_size(const ArmSetPoint& point, Eigen::Index n) {
  return point.q.size() == n && point.dq.size() == n && point.ddq.size() == n;
}

bool is_agents(std::uint32_t fault) { return (fault & 0x8000'0000) != 0; }

std::uint32_t fault_of(DeviceSession::End end) {
  if (end == DeviceSession::End::kSilent) return ArmAgent::kSilent;
  if (end == DeviceSession::End::kFailed) return ArmAgent::kFailed;
  return end == DeviceSession::End::kDisagrees ? ArmAgent::kDisagrees : ArmAgent::kRestarted;
}

}  // namespace

std::string ArmAgent::fault_text(std::uint32_t fault) {
  if (fault == kDry) return "the set points ran out: the agent stopped the arm";
  if (fault == kElsewhere) return "the first set point is away from the commanded position of the arm";
  if (fault == kStep) return "the set points would have made the arm step: the agent stopped it";
  if (fault == kSilent) return "the device was silent for too long: it begins anew once no net holds it";
  if (fault == kRestarted) return "the device began to count anew: it is taken up again once no net holds it";
  if (fault == kDisagrees) return "the device's clock and its counter disagree: check the declared cycle of the device";
  if (fault == kFailed) return "the driver failed, and standard error says how: it begins anew once no net holds it";
  return {};
}

ArmAgent::ArmAgent(const motion::JointLimits& limits, const AgentTiming& timing, const Clock& clock)
    : limits_(limits),
      timing_(timing),
      clock_(clock),
      session_({.cycle = timing.device_cycle, .sequence_bits = timing.sequence_bits, .jitter = timing.margin}),
      guard_(limits, timing.core_period) {}

// -- The core's side
// ---------------------------------------------------------------------------------------------------

bool ArmAgent::read(ArmSample& sample) {
  inbound_.take();
  const Inbound& newest = inbound_.value();
  sample = newest.sample;
  // Each end of readiness is shown for at least one cycle, so that no net outlives it, however short it was.
  const bool unseen = newest.report.stops != stops_seen_;
  stops_seen_ = newest.report.stops;
  stops_shown_.store(stops_seen_, std::memory_order_release);
  sample.stamp -= clock_.read().skipped;
  sample.ready = newest.willing && !unseen;
  if (sample.ready && is_agents(sample.fault)) sample.fault = 0;
  return newest.sample.sequence > 0;
}

void ArmAgent::write(const ArmSetPoint& set_point) {
  if (!ring_.push({set_point, stops_seen_})) dropped_.fetch_add(1, std::memory_order_relaxed);
}

// -- The device's side
// -------------------------------------------------------------------------------------------------

std::optional<ArmAnswer> ArmAgent::answer(const ArmPacket& packet) {
  if (!usable(packet.sample)) {
    session_.count_implausible();
    return std::nullopt;
  }
  const Clock::Reading now = clock_.read();
  switch (session_.take({packet.sample.sequence, packet.instant}, now.machine, may_open())) {
    case DeviceSession::Verdict::kDropped:
      return std::nullopt;
    case DeviceSession::Verdict::kEnded:
      lose_session();
      return std::nullopt;
    case DeviceSession::Verdict::kOpened:
      begin_session();
      break;
    case DeviceSession::Verdict::kAccepted:
      break;
  }
  take_state(packet.sample);
  take_set_points();

  const Nanoseconds instant = session_.instant() + timing_.dead_time();
  advance_target(instant, now.skipped);
  guard_.answered(next_state(instant), instant);
  take_sample(packet.sample, now.machine);
  publish();
  return ArmAnswer{.sequence = packet.sample.sequence,
                   .session = session_.counts().restarts,
                   .instant = instant,
                   .state = guard_.last(),
                   .brake = brake_requested_.load(std::memory_order_acquire)};
}

void ArmAgent::fail() {
  session_.close();
  lose_session();
}

/// Row N5 for what an answer is made of; all else is the core's to judge.
bool ArmAgent::usable(const ArmSample& sample) const {
  return sample.commanded.size() == limits_.velocity.size() && sample.commanded.allFinite();
}

/// The core has seen that the arm stopped, and no net holds it any more.
bool ArmAgent::may_open() const {
  return stops_shown_.load(std::memory_order_acquire) == report_.stops && !held_.load(std::memory_order_acquire);
}

void ArmAgent::begin_session() {
  series_.clear();
  device_ready_ = false;
  phase_ = Phase::kWaiting;
}

void ArmAgent::lose_session() {
  ++report_.lost_sessions;
  end_readiness(fault_of(session_.end()));
  device_ready_ = false;
  phase_ = Phase::kWaiting;
  publish();
}

void ArmAgent::take_state(const ArmSample& sample) {
  const bool was_ready = device_ready_;
  device_ready_ = sample.ready;
  if (was_ready && !device_ready_) end_readiness(0);
  if (phase_ == Phase::kWaiting || !device_ready_) phase_ = Phase::kHolding;
  // A device that took no set points stands where it says.
  if (!was_ready || !device_ready_) guard_.rest_at(sample.commanded, session_.instant());
  if (!device_ready_) brake_requested_.store(false, std::memory_order_release);
}

void ArmAgent::take_set_points() {
  Tagged tagged;
  while (ring_.pop(tagged)) {
    const bool counts = tagged.stops == report_.stops && phase_ != Phase::kBraking;
    if (counts && has_size(tagged.set_point, limits_.velocity.size())) series_.add(tagged.set_point);
  }
}

/// Where the core's motion is read for an instant of the device. While the arm stands the estimate of its clock counts
/// as it is; while it moves, corrections are spread, so that they do not show as steps in velocity.
void ArmAgent::advance_target(Nanoseconds instant, Nanoseconds skipped) {
  const ClockEstimator& estimator = session_.estimator();
  const Nanoseconds estimated = estimator.to_core(instant) - skipped - timing_.delay();
  if (phase_ != Phase::kFollowing) {
    target_ = estimated;
  } else {
    const auto elapsed = static_cast<double>(instant - target_for_);
    const Nanoseconds expected = target_ + std::llround(elapsed * (1.0 + estimator.drift()));
    const Nanoseconds most = std::llround(kSlew * std::abs(elapsed));
    target_ = expected + std::clamp(estimated - expected, -most, most);
  }
  target_for_ = instant;
}

motion::JointSample ArmAgent::next_state(Nanoseconds instant) {
  switch (phase_) {
    case Phase::kBraking:
      return continue_braking(instant);
    case Phase::kHolding:
      if (series_.empty() || !device_ready_) return guard_.last();
      if (!begins_at(series_.first(), guard_.last().q)) {
        end_readiness(kElsewhere);
        return guard_.last();
      }
      phase_ = Phase::kFollowing;
      return follow(instant);
    case Phase::kFollowing:
      return follow(instant);
    case Phase::kWaiting:
      break;
  }
  return guard_.last();
}

motion::JointSample ArmAgent::follow(Nanoseconds instant) {
  report_.reserve_least = std::min(report_.reserve_least, series_.newest() - target_);
  motion::JointSample state;
  const SetPointSeries::Place place = series_.sample(target_, state);
  if (place == SetPointSeries::Place::kBeyond || place == SetPointSeries::Place::kEmpty) {
    ++report_.dry;
    end_readiness(kDry);
    return start_braking(instant);
  }
  if (const auto violation = guard_.check(state, instant)) {
    ++report_.trips;
    report_.last_trip = violation;
    end_readiness(kStep);
    return start_braking(instant);
  }
  return state;
}

void ArmAgent::end_readiness(std::uint32_t fault) {
  ++report_.stops;
  fault_ = fault;
  series_.clear();
}

motion::JointSample ArmAgent::start_braking(Nanoseconds instant) {
  ramp_ = BrakeRamp(guard_.last(), limits_);
  ramp_begin_ = guard_.last_instant();
  phase_ = Phase::kBraking;
  return continue_braking(instant);
}

motion::JointSample ArmAgent::continue_braking(Nanoseconds instant) {
  const double time = to_seconds(instant - ramp_begin_);
  if (time >= ramp_.duration()) phase_ = Phase::kHolding;
  return ramp_.sample(time);
}

void ArmAgent::take_sample(const ArmSample& sample, Nanoseconds received) {
  newest_.sample = sample;
  newest_.sample.sequence = session_.number();
  // Measured before it came, whatever the estimate says.
  newest_.sample.stamp = session_.measured_at(sample.stamp, received);
  if (phase_ != Phase::kFollowing) newest_.sample.commanded = guard_.last().q;
  if (newest_.sample.fault == 0) newest_.sample.fault = fault_;
}

void ArmAgent::publish() {
  report_.phase = phase_;
  report_.samples = session_.counts();
  report_.clock_steps = session_.clock_steps();
  report_.dropped = dropped_.load(std::memory_order_relaxed);
  report_.drift = session_.estimator().drift();
  report_.offset = session_.estimator().offset();
  report_.packet_time.reset();
  if (session_.open()) report_.packet_time = session_.estimator().to_core(session_.instant());
  report_.jitter = session_.estimator().jitter();
  if (!session_.open()) newest_.sample.fault = fault_;
  newest_.willing = session_.open() && device_ready_ && phase_ != Phase::kBraking;
  newest_.report = report_;
  inbound_.publish(newest_);
}

}  // namespace takt::device
