#include "scenario/faulty_sensor.h"

#include <algorithm>
#include <limits>

namespace takt::scenario {

bool FaultySensor::read(device::WrenchSample& sample) {
  if (!sensor_->read(sample)) return false;
  kept_[count_++ % kKept] = sample;
  return !fault_ || spoil(sample);
}

bool FaultySensor::spoil(device::WrenchSample& sample) {
  switch (fault_->kind) {
    case SensorFault::Kind::kSilent:
      return false;
    case SensorFault::Kind::kNan:
      sample.wrench.force.setConstant(std::numeric_limits<double>::quiet_NaN());
      return true;
    case SensorFault::Kind::kStuck:
      if (!stuck_) stuck_ = sample.wrench;
      sample.wrench = *stuck_;
      return true;
    case SensorFault::Kind::kBias:
      sample.wrench.force += fault_->wrench.force;
      sample.wrench.torque += fault_->wrench.torque;
      return true;
    case SensorFault::Kind::kNoise:
      add_noise(sample.wrench);
      return true;
    case SensorFault::Kind::kDelay:
      return read_late(sample);
  }
  return true;
}

void FaultySensor::add_noise(net::Wrench& wrench) {
  for (int axis = 0; axis < 3; ++axis) wrench.force[axis] += fault_->wrench.force[axis] * random_.normal();
  for (int axis = 0; axis < 3; ++axis) wrench.torque[axis] += fault_->wrench.torque[axis] * random_.normal();
}

/// The newest that is old enough; before there is one, none.
bool FaultySensor::read_late(device::WrenchSample& sample) const {
  const Nanoseconds before = sample.stamp - fault_->delay;
  for (std::size_t back = 0; back < std::min(count_, kKept); ++back) {
    const device::WrenchSample& kept = kept_[(count_ - 1 - back) % kKept];
    if (kept.stamp > before) continue;
    sample = kept;
    return true;
  }
  return false;
}

}  // namespace takt::scenario
