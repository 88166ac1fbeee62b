#include "core/device/force_torque_sensor.h"

#include <utility>

namespace takt::device {

ForceTorqueSensor::ForceTorqueSensor(std::string name, std::shared_ptr<const ForceTorqueDescription> description,
                                     std::shared_ptr<ForceTorqueBackend> backend)
    : name_(std::move(name)), description_(std::move(description)), backend_(std::move(backend)) {}

void ForceTorqueSensor::begin_cycle(Nanoseconds time) {
  has_sample_ = backend_->read(sample_) && sample_.wrench.force.allFinite() && sample_.wrench.torque.allFinite();
  sample_age_ = has_sample_ ? time - sample_.stamp : 0;
  if (sample_age_ > description_->sample_age_max) has_sample_ = false;
}

}  // namespace takt::device
