#include "core/device/arm_agent.h"

#include <algorithm>
#include <cmath>

namespace takt::device {

namespace {

// The core takes an arm over where it was told to be, bit for bit; what differs more than by rounding is a step.
constexpr double kSamePlace = 1e-9;  // rad or m

motion::JointSample rest_at(const JointVector& q) {
  return {q, JointVector::Zero(q.size()), JointVector::Zero(q.size())};
}

bool begins_at(const ArmSetPoint& first, const JointVector& q) {
  return first.q.size() == q.size() && (first.q - q).cwiseAbs().maxCoeff() <= kSamePlace && first.dq.isZero(kSamePlace);
}

bool is_agents(std::uint32_t fault) { return (fault & 0x8000'0000) != 0; }

}  // namespace

std::string ArmAgent::fault_text(std::uint32_t fault) {
  if (fault == kDry) return "the set points ran out: the agent stopped the arm";
  if (fault == kElsewhere) return "set points began elsewhere than where the arm was told to be";
  return {};
}

ArmAgent::ArmAgent(const motion::JointLimits& limits, const AgentTiming& timing, const Clock& clock)
    : limits_(limits), timing_(timing), clock_(clock) {}

// -- The core's side
// ---------------------------------------------------------------------------------------------------

bool ArmAgent::read(ArmSample& sample) {
  inbound_.take();
  const Inbound& newest = inbound_.value();
  sample = newest.sample;
  // Each end of readiness is shown for at least one cycle, so that no net outlives it, however short it was.
  const bool unseen = newest.report.stops != stops_seen_;
  stops_seen_ = newest.report.stops;
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
  if (!inlet_.accept(packet.sample.sequence)) return std::nullopt;
  estimator_.add(packet.instant, clock_.now());
  take_state(packet.sample);
  take_set_points();

  const Nanoseconds instant = packet.instant + timing_.dead_time();
  advance_target(instant);
  told_ = next_state(instant);
  told_for_ = instant;
  publish(packet);
  return ArmAnswer{.sequence = packet.sample.sequence,
                   .instant = instant,
                   .state = told_,
                   .brake = brake_requested_.load(std::memory_order_acquire)};
}

void ArmAgent::take_state(const ArmSample& sample) {
  const bool was_ready = device_ready_;
  device_ready_ = sample.ready;
  if (was_ready && !device_ready_) end_readiness(0);
  if (phase_ == Phase::kWaiting || !device_ready_) phase_ = Phase::kHolding;
  // A device that took no set points stands where it says.
  if (!was_ready || !device_ready_) told_ = rest_at(sample.commanded);
  if (!device_ready_) brake_requested_.store(false, std::memory_order_release);
}

void ArmAgent::take_set_points() {
  Tagged tagged;
  while (ring_.pop(tagged))
    if (tagged.stops == report_.stops && phase_ != Phase::kBraking) series_.add(tagged.set_point);
}

/// Where the core's motion is read for an instant of the device. While the arm stands the estimate of its clock counts
/// as it is; while it moves, corrections are spread, so that they do not show as steps in velocity.
void ArmAgent::advance_target(Nanoseconds instant) {
  const Nanoseconds estimated = estimator_.to_core(instant) - timing_.delay();
  if (phase_ != Phase::kFollowing) {
    target_ = estimated;
  } else {
    const auto elapsed = static_cast<double>(instant - target_for_);
    const Nanoseconds expected = target_ + std::llround(elapsed * (1.0 + estimator_.drift()));
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
      if (series_.empty() || !device_ready_) return told_;
      if (!begins_at(series_.first(), told_.q)) {
        end_readiness(kElsewhere);
        return told_;
      }
      phase_ = Phase::kFollowing;
      return follow(instant);
    case Phase::kFollowing:
      return follow(instant);
    case Phase::kWaiting:
      break;
  }
  return told_;
}

motion::JointSample ArmAgent::follow(Nanoseconds instant) {
  report_.reserve_least = std::min(report_.reserve_least, series_.newest() - target_);
  motion::JointSample state;
  switch (series_.sample(target_, state)) {
    case SetPointSeries::Place::kBefore:
    case SetPointSeries::Place::kInside:
      return state;
    case SetPointSeries::Place::kBeyond:
    case SetPointSeries::Place::kEmpty:
      break;
  }
  ++report_.dry;
  end_readiness(kDry);
  return start_braking(instant);
}

void ArmAgent::end_readiness(std::uint32_t fault) {
  ++report_.stops;
  fault_ = fault;
  series_.clear();
}

motion::JointSample ArmAgent::start_braking(Nanoseconds instant) {
  ramp_ = BrakeRamp(told_, limits_);
  ramp_begin_ = told_for_;
  phase_ = Phase::kBraking;
  return continue_braking(instant);
}

motion::JointSample ArmAgent::continue_braking(Nanoseconds instant) {
  const double time = to_seconds(instant - ramp_begin_);
  if (time >= ramp_.duration()) phase_ = Phase::kHolding;
  return ramp_.sample(time);
}

void ArmAgent::publish(const ArmPacket& packet) {
  report_.phase = phase_;
  report_.samples = inlet_.counts();
  report_.dropped = dropped_.load(std::memory_order_relaxed);
  report_.drift = estimator_.drift();
  report_.offset = estimator_.offset();
  report_.jitter = estimator_.jitter();
  Inbound inbound{packet.sample, device_ready_ && phase_ != Phase::kBraking, report_};
  // Measured before it came, whatever the estimate says.
  inbound.sample.stamp = std::min(estimator_.to_core(packet.sample.stamp), clock_.now());
  if (phase_ != Phase::kFollowing || inbound.sample.commanded.size() == 0) inbound.sample.commanded = told_.q;
  if (inbound.sample.fault == 0) inbound.sample.fault = fault_;
  inbound_.publish(inbound);
}

}  // namespace takt::device
