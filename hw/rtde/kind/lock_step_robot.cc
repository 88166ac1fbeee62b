#include "hw/rtde/kind/lock_step_robot.h"

#include <algorithm>

#include "hw/wire/virtual_stream.h"

namespace takt::hw::rtde {

namespace {

constexpr Nanoseconds kSocketTime = 20 * kMillisecond;  // of the machine, for a package on its sockets

}  // namespace

LockStepRobot::LockStepRobot(const DriverOptions& options, const ControllerOptions& controller,
                             const device::DriverRequest& request, std::shared_ptr<device::ArmBackend> machine,
                             const hw::VirtualFaults& faults, const emulation::DeviceClock& device_clock,
                             hw::Network* sockets)
    : options_(options),
      period_(request.core_period),
      block_(request.terminals),
      machine_(std::move(machine)),
      network_(clock_, request.seed, faults),
      on_sockets_(sockets != nullptr),
      robot_(controller, request.description, machine_, on_sockets_ ? *sockets : network_, device_clock),
      driver_(options, request, on_sockets_ ? *sockets : network_, clock_) {}

bool LockStepRobot::read(device::ArmSample& sample) {
  pass_cycle();
  return driver_.read(sample);
}

device::IoDriver* LockStepRobot::terminals(const device::IoTerminals& machine) {
  if (block_ != nullptr) robot_.set_terminals(*block_, machine);
  return driver_.terminals(machine);
}

void LockStepRobot::pass_cycle() { advance(++cycle_ * period_); }

void LockStepRobot::set_payload(const device::PayloadSetting& payload) {
  machine_->set_payload(payload);
  driver_.set_payload(payload);
}

/// All that happens up to now, in the order of time. The arm is known at the core's cycles only: what happens between
/// two of them sees the state of the earlier one.
void LockStepRobot::advance(Nanoseconds now) {
  for (;;) {
    // What has arrived and was not taken has been offered already.
    const Nanoseconds arrival = network_.next_arrival();
    const Nanoseconds next = std::min(arrival > clock_.now() ? arrival : hw::VirtualPipe::kNever, robot_.next_frame());
    if (next >= now) break;
    clock_.set(std::max(next, clock_.now()));
    serve(next);
  }
  clock_.set(now);
  robot_.look();
  serve(now);
  robot_.tell(cycle_, now);
  state_.begin();
  state_.add(driver_.hash());
  state_.add(robot_.controller().frame());
}

/// Both ends have their turn. What goes over sockets is there a moment later: the driver waits for the package of a
/// frame.
void LockStepRobot::serve(Nanoseconds now) {
  const std::uint64_t frame = robot_.controller().frame();
  robot_.serve(now);
  if (frozen) return;
  if (on_sockets_ && robot_.controller().frame() != frame && robot_.front()->clients() > 0) driver_.wait(kSocketTime);
  driver_.poll();
}

void LockStepRobot::reset() {
  (void)robot_.controller().power().unlock();
  driver_.reset();
}

}  // namespace takt::hw::rtde
