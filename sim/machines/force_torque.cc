#include "sim/machines/force_torque.h"

#include <cmath>
#include <numbers>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

Eigen::Matrix<double, 6, 1> stacked(const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
  Eigen::Matrix<double, 6, 1> both;
  both << force, torque;
  return both;
}

}  // namespace

SimForceTorque::SimForceTorque(const SimForceTorqueDescription& description, int force_address, int torque_address,
                               const Physics& physics, std::uint64_t seed)
    : force_address_(force_address),
      torque_address_(torque_address),
      timestep_(physics.timestep),
      period_(description.period),
      core_period_(physics.period),
      range_(stacked(description.force_range, description.torque_range)),
      sigma_(stacked(description.force_noise, description.torque_noise)),
      bias_(stacked(description.force_bias, description.torque_bias)),
      noise_(seed, description.name) {
  for (int i = 0; i < 6; ++i) bias_[i] *= noise_.normal();
  if (description.low_pass_Hz > 0.0) {
    filter_delay_ = std::llround(1e9 / (2.0 * std::numbers::pi * description.low_pass_Hz));
    filter_gain_ = 1.0 - std::exp(-2.0 * std::numbers::pi * description.low_pass_Hz * to_seconds(physics.period));
  }
}

bool SimForceTorque::read(device::WrenchSample& sample) {
  sample = sample_;
  return sample_.sequence > 0;
}

device::BackendTiming SimForceTorque::timing() const {
  return {.cycle = period_, .sample_age = period_ - core_period_ + timestep_ + filter_delay_};
}

void SimForceTorque::measure(const mjData_& data, Nanoseconds now) {
  Channels load;
  for (int i = 0; i < 3; ++i) {
    load[i] = -data.sensordata[force_address_ + i];
    load[3 + i] = -data.sensordata[torque_address_ + i];
  }
  filtered_ = sample_.sequence == 0 ? load : Channels(filtered_ + filter_gain_ * (load - filtered_));
  if (now % period_ != 0) return;

  Channels reading = filtered_ + bias_;
  for (int i = 0; i < 6; ++i) reading[i] += sigma_[i] * noise_.normal();
  const Channels clipped = reading.cwiseMin(range_).cwiseMax(-range_);
  sample_.overload = (clipped.array().abs() >= range_.array()).any();
  ++sample_.sequence;
  sample_.stamp = now - last_step_;
  sample_.wrench.force = clipped.head<3>();
  sample_.wrench.torque = clipped.tail<3>();
}

void SimForceTorque::stream(StateStream& state) {
  std::uint64_t random = noise_.state();
  state(random);
  noise_ = Random(random);
  state.vector(filtered_);
  state(sample_.sequence);
  state(sample_.stamp);
  state.vector(sample_.wrench.force);
  state.vector(sample_.wrench.torque);
  state(sample_.overload);
}

}  // namespace takt::sim
