#include "core/emulation/slow_controller.h"

#include "core/device/set_point_series.h"

namespace takt::emulation {

using kinematics::JointVector;
using motion::JointSample;

namespace {

constexpr int kSeries = 8;  // answers in time after a stop, before the controller takes set points again

}  // namespace

void SlowController::stand(const JointVector& q) {
  from_ = to_ = {q, JointVector::Zero(q.size()), JointVector::Zero(q.size())};
  pending_ = {};
  commanded_ = timed_out_ = false;
  missing_ = in_time_ = 0;
  resampled_ = -1;
}

void SlowController::take(const device::ArmAnswer& answer, Nanoseconds resampled) {
  pending_[next_pending_] = {answer.instant, resampled, answer.state};
  next_pending_ = (next_pending_ + 1) % pending_.size();
}

const SlowController::Pending* SlowController::find(Nanoseconds instant) const {
  for (const Pending& pending : pending_)
    if (pending.instant == instant) return &pending;
  return nullptr;
}

bool SlowController::begin_cycle(Nanoseconds instant) {
  begin_ = instant;
  from_ = to_;
  resampled_ = -1;
  const Pending* pending = find(instant + cycle_);
  if (pending != nullptr && !timed_out_) {
    to_ = pending->state;
    resampled_ = pending->resampled;
    commanded_ = true;
    missing_ = 0;
    return true;
  }
  in_time_ = pending != nullptr ? in_time_ + 1 : 0;
  bridge(instant);
  return pending != nullptr || !commanded_;
}

void SlowController::bridge(Nanoseconds instant) {
  if (!commanded_) return;
  if (timed_out_) {
    const double time = to_seconds(instant + cycle_ - ramp_begin_);
    to_ = ramp_.sample(time);
    if (time < ramp_.duration()) in_time_ = 0;
    if (in_time_ >= kSeries) stand(JointVector(to_.q));
    return;
  }
  ++missed_;
  if (++missing_ > answer_timeout_cycles_) {
    timed_out_ = true;
    ramp_ = device::BrakeRamp(from_, limits_);
    ramp_begin_ = instant;
    to_ = ramp_.sample(to_seconds(cycle_));
    return;
  }
  const double h = to_seconds(cycle_);
  to_.q += h * from_.dq + (0.5 * h * h) * from_.ddq;
  to_.dq += h * from_.ddq;
}

JointSample SlowController::at(Nanoseconds device_time) const {
  return device::interpolate(from_, to_, to_seconds(cycle_), to_seconds(device_time - begin_));
}

void SlowController::add_state(StateHash& hash) const {
  hash.add(from_);
  hash.add(to_);
  hash.add(begin_);
  hash.add(std::int64_t{missing_} << 32 | in_time_ << 2 | (timed_out_ ? 2 : 0) | (commanded_ ? 1 : 0));
  for (const Pending& pending : pending_) {
    hash.add(pending.instant);
    hash.add(pending.state);
  }
}

}  // namespace takt::emulation
