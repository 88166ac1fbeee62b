#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/clock.h"
#include "core/device/force_torque_agent.h"
#include "core/emulation/slow_options.h"
#include "core/emulation/state_hash.h"

namespace takt::emulation {

/// A slow force/torque sensor around one that lives in the core's cycle: it gives a reading in each cycle of its own
/// clock, over a wire with faults, through the I/O agent. read() makes time go on by one core cycle, so it is called
/// once in each. Realtime: cyclic but for the constructor.
class SlowForceTorque final : public device::ForceTorqueBackend {
 public:
  SlowForceTorque(const std::string& name, std::shared_ptr<device::ForceTorqueBackend> inner,
                  const SlowOptions& options, Nanoseconds core_period, std::uint64_t seed);

  bool read(device::WrenchSample& sample) override;
  [[nodiscard]] device::BackendTiming timing() const override;

  [[nodiscard]] const device::ForceTorqueAgent::Report& report() const { return agent_.report(); }
  [[nodiscard]] const StateHash& state() const { return state_; }

 private:
  struct Packet {
    device::WrenchSample sample;
    Nanoseconds instant = 0;
  };

  void advance(Nanoseconds now);
  void look_at_plant();
  void begin_device_cycle();
  void hash_state();

  std::shared_ptr<device::ForceTorqueBackend> inner_;
  SlowOptions options_;
  Nanoseconds core_period_;
  DeviceClock device_clock_;
  VirtualClock core_clock_;
  device::ForceTorqueAgent agent_;
  Wire<Packet> to_core_;
  std::int64_t core_cycle_ = -1;
  std::int64_t device_cycle_;
  std::uint64_t sequence_ = 0;
  device::WrenchSample plant_;
  bool has_plant_ = false, looked_ = false;
  StateHash state_;
};

}  // namespace takt::emulation
