#include "hw/emulators/rtde/emulated_robot.h"

#include "core/device/set_point_series.h"

namespace takt::hw::rtde {

EmulatedRobot::EmulatedRobot(const ControllerOptions& options, std::shared_ptr<const device::ArmDescription> arm,
                             std::shared_ptr<device::ArmBackend> plant, hw::Network& network,
                             const emulation::DeviceClock& clock)
    : options_(options),
      arm_(std::move(arm)),
      plant_(std::move(plant)),
      network_(network),
      clock_(clock),
      controller_(std::make_unique<Controller>(options, arm_, &network)),
      next_frame_(clock.to_device(0) / controller_->cycle() + 1) {}

Result<void> EmulatedRobot::listen(std::uint32_t host) {
  host_ = host;
  auto front = Front::open(network_, host, *controller_);
  if (!front) return std::unexpected(front.error());
  front_ = std::move(*front);
  return {};
}

void EmulatedRobot::serve(Nanoseconds now) {
  if (front_ != nullptr) front_->exchange();
  while (next_frame() <= now) {
    frame_begin_ = next_frame_++ * controller_->cycle();
    if (!has_sample_) {
      controller_->skip_frame();
      continue;
    }
    controller_->run_frame({sample_.q, sample_.dq, sample_.tau_external, sample_.commanded, plant_stopped_});
    if (front_ != nullptr) front_->end_frame();
  }
  follow_power();
  follow_plant();
}

/// A machine that has stopped by itself, pushed or at the end of its range, is a protective stop. Who unlocks that has
/// looked at the machine.
void EmulatedRobot::follow_plant() {
  if (!has_sample_ || braked_) return;
  const bool stopped = !sample_.ready, reset = plant_stopped_ && controller_->power().can_move();
  if (stopped && reset && open_brakes) open_brakes();
  if (stopped && (!plant_stopped_ || (reset && !open_brakes)))
    controller_->protective_stop(plant_->fault_text(sample_.fault));
  plant_stopped_ = stopped;
}

void EmulatedRobot::follow_power() {
  const bool on = controller_->power().drives_on();
  if (!on && !braked_ && close_brakes) close_brakes();
  if (on && braked_ && open_brakes) open_brakes();
  if (on && braked_) plant_stopped_ = true;  // until it says that it is ready
  braked_ = !on;
}

void EmulatedRobot::tell(std::int64_t cycle, Nanoseconds now) {
  if (terminals_) terminals_->write_outputs(controller_->io());
  if (!has_sample_ || !sample_.ready || !controller_->power().drives_on() || controller_->frame() == 0) return;
  const motion::JointSample state =
      device::interpolate(controller_->told(), controller_->told_next(), to_seconds(controller_->cycle()),
                          to_seconds(clock_.to_device(now) - frame_begin_));
  plant_->write({.cycle = cycle, .stamp = now, .q = state.q, .dq = state.dq, .ddq = state.ddq});
}

void EmulatedRobot::restart() {
  front_.reset();
  controller_ = std::make_unique<Controller>(options_, arm_, &network_);
  if (host_ != 0) (void)listen(host_);
}

}  // namespace takt::hw::rtde
