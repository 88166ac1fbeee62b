#include "hw/emulators/fri/emulator.h"

#include <algorithm>

namespace takt::hw::fri {
namespace {

std::int64_t first_cycle(const emulation::DeviceClock& clock, Nanoseconds cycle) {
  std::int64_t first = clock.to_device(0) / cycle - 1;
  while (clock.to_core(first * cycle) < 0) ++first;
  return first;
}

}  // namespace

Emulator::Emulator(const device::DriverRequest& request, const ControllerOptions& options,
                   std::unique_ptr<DatagramLink> link, const Endpoint& remote,
                   std::shared_ptr<device::ArmBackend> machine, const emulation::DeviceClock& clock)
    : options_(options),
      link_(std::move(link)),
      remote_(remote),
      machine_(std::move(machine)),
      clock_(clock),
      controller_(request.description, options),
      cycle_(first_cycle(clock, options.cycle)) {}

void Emulator::advance(Nanoseconds now) {
  look();
  receive(now);
  while (next_cycle() <= now) begin_cycle();
  drive(now);
}

void Emulator::look() { has_sample_ = machine_->read(sample_); }

void Emulator::receive(Nanoseconds now) {
  while (const auto received = link_->receive(buffer_)) {
    if (received->from.host != remote_.host) {
      ++counts_.strangers;
      continue;
    }
    take(std::span(buffer_).first(std::min(received->size, buffer_.size())), now);
  }
}

void Emulator::take(std::span<const std::byte> datagram, Nanoseconds now) {
  const auto command = decode_command(datagram);
  ++(command ? counts_.commands : counts_.misread);
  if (command) controller_.take(*command, clock_.to_device(now));
}

void Emulator::begin_cycle() {
  const Nanoseconds now = next_cycle(), instant = cycle_++ * options_.cycle;
  if (!has_sample_) return;
  // The arm is known once in each cycle of its own; the controller measures at the beginning of its.
  device::ArmSample measured = sample_;
  measured.q += to_seconds(now - sample_.stamp) * sample_.dq;
  controller_.begin_cycle(instant, measured);
  const Measurement* measurement = controller_.measurement();
  if (measurement == nullptr) return;
  encode(*measurement, std::span(buffer_).first<kMeasurementSize>());
  (void)link_->send(std::span(buffer_).first(kMeasurementSize), remote_);
}

void Emulator::drive(Nanoseconds now) {
  if (!has_sample_ || !sample_.ready) return;
  if (sample_.mode != controller_.mode() && !sample_.changing_mode) machine_->change_mode(controller_.mode());
  if (sample_.mode != device::ControlMode::kPosition && sample_.mode == controller_.mode())
    machine_->write_compliance(controller_.compliance());
  const motion::JointSample state = controller_.at(clock_.to_device(now));
  machine_->write({.cycle = driven_++, .stamp = now, .q = state.q, .dq = state.dq, .ddq = state.ddq});
}

}  // namespace takt::hw::fri
