#include "core/device/force_torque_sensor.h"

#include <utility>

namespace takt::device {

ForceTorqueSensor::ForceTorqueSensor(std::string name, std::shared_ptr<const ForceTorqueDescription> description,
                                     std::shared_ptr<ForceTorqueBackend> backend)
    : Device(std::move(name)), description_(std::move(description)), backend_(std::move(backend)) {}

void ForceTorqueSensor::begin_cycle(std::int64_t, Nanoseconds time) {
  has_sample_ = at_border([this] { return backend_->read(sample_); }) && sample_.wrench.force.allFinite() &&
                sample_.wrench.torque.allFinite();
  sample_age_ = has_sample_ ? time - sample_.stamp : 0;
  if (sample_age_ > description_->sample_age_max) has_sample_ = false;
}

void ForceTorqueSensor::add_state(StateWords& words) const {
  words.add(std::uint64_t{has_sample_} | std::uint64_t{sample_.overload} << 1);
  if (!has_sample_) return;
  words.add(sample_.sequence);
  words.add(sample_.stamp);
  words.add(sample_.wrench.force);
  words.add(sample_.wrench.torque);
}

}  // namespace takt::device
