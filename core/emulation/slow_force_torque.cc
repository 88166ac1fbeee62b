#include "core/emulation/slow_force_torque.h"

#include <algorithm>

namespace takt::emulation {

SlowForceTorque::SlowForceTorque(const std::string& name, std::shared_ptr<device::ForceTorqueBackend> inner,
                                 const SlowOptions& options, Nanoseconds core_period, std::uint64_t seed)
    : inner_(std::move(inner)),
      options_(options),
      core_period_(core_period),
      device_clock_(options.clock()),
      agent_(core_clock_, options.cycle, options.wire.jitter),
      to_core_(options.wire, seed, name + "/to core"),
      device_cycle_(options.first_cycle()) {}

bool SlowForceTorque::read(device::WrenchSample& sample) {
  advance(++core_cycle_ * core_period_);
  return agent_.read(sample);
}

void SlowForceTorque::advance(Nanoseconds now) {
  looked_ = false;
  for (;;) {
    const Nanoseconds instant = device_clock_.to_core(device_cycle_ * options_.cycle);
    const Nanoseconds arrival = to_core_.next_arrival();
    const Nanoseconds next = std::min(instant, arrival);
    if (next > now) break;
    core_clock_.set(next);
    if (next == now) look_at_plant();
    if (next == instant) {
      begin_device_cycle();
    } else {
      const Packet packet = to_core_.receive();
      agent_.take(packet.sample, packet.instant);
    }
  }
  core_clock_.set(now);
  look_at_plant();
  hash_state();
}

void SlowForceTorque::look_at_plant() {
  if (looked_) return;
  looked_ = true;
  has_plant_ = inner_->read(plant_);
}

void SlowForceTorque::begin_device_cycle() {
  const Nanoseconds instant = device_cycle_++ * options_.cycle;
  ++sequence_;
  if (!has_plant_) return;
  Packet packet{plant_, instant};
  packet.sample.sequence = sequence_;
  packet.sample.stamp = device_clock_.to_device(plant_.stamp);
  to_core_.send(packet, core_clock_.now());
}

device::BackendTiming SlowForceTorque::timing() const {
  return {.cycle = options_.cycle,
          .sample_age = options_.cycle + options_.wire.slowest() + core_period_ + inner_->timing().sample_age};
}

void SlowForceTorque::hash_state() {
  state_.begin();
  state_.add(device_cycle_);
  state_.add(sequence_);
  state_.add(to_core_.random().state());
  to_core_.for_each([this](const Packet& packet, Nanoseconds arrival) {
    state_.add(arrival);
    state_.add(packet.sample.sequence);
    state_.add(packet.sample.stamp);
    state_.add(packet.sample.wrench.force);
    state_.add(packet.sample.wrench.torque);
  });
}

}  // namespace takt::emulation
