#pragma once

#include <cstdint>

#include "core/base/random.h"
#include "core/device/backend.h"
#include "sim/model/device.h"
#include "sim/model/world_description.h"

namespace takt::sim {

/// A six-axis force/torque sensor, raw, in its measuring frame S: what the surroundings and gravity exert on the tool
/// side, less what accelerates it; plus bias and noise; low-passed, sampled at its period, clipped at its range.
/// A tool of 2 kg under a level sensor reads -19.62 N along the upward axis. Source of the sign: core/device/backend.h;
/// MuJoCo's sensors give what the parent exerts on the child, the opposite.
/// The wrench is that of the last physics step, so its stamp lies one physics step before the end of the cycle.
/// Owned by its World. Thread: the one that steps the world. Realtime: cyclic.
class SimForceTorque final : public device::ForceTorqueBackend, public SimDevice {
 public:
  /// @param force_address, torque_address  of the two MuJoCo sensors in the sensor vector
  SimForceTorque(const SimForceTorqueDescription& description, int force_address, int torque_address,
                 const Physics& physics, std::uint64_t seed);

  bool read(device::WrenchSample& sample) override;
  /// The delay of the low-pass counts as age.
  [[nodiscard]] device::BackendTiming timing() const override;

  void start(const mjData_&) override {}
  void actuate(mjData_&, const Substep& step) override { last_step_ = step.length; }
  void measure(const mjData_& data, Nanoseconds now) override;
  void stream(StateStream& state) override;

 private:
  using Channels = Eigen::Matrix<double, 6, 1>;  // force, torque

  int force_address_;
  int torque_address_;
  Nanoseconds timestep_;
  Nanoseconds last_step_ = 0;  ///< set in each cycle before it is read
  Nanoseconds period_;
  Nanoseconds core_period_;
  Nanoseconds filter_delay_ = 0;  // of the low-pass, for slow signals
  double filter_gain_ = 1.0;      // of the low-pass per cycle
  Channels range_, sigma_, bias_;
  Random noise_;

  Channels filtered_ = Channels::Zero();
  device::WrenchSample sample_;
};

}  // namespace takt::sim
