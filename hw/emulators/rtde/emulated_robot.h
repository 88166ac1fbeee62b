#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "core/device/backend.h"
#include "core/emulation/device_clock.h"
#include "hw/emulators/rtde/controller.h"
#include "hw/emulators/rtde/front.h"
#include "hw/emulators/rtde/wired_terminals.h"

namespace takt::hw::rtde {

/// A robot: an emulated UR controller with an arm, and the interfaces at which clients find it. The arm is any back end
/// that lives in the core's cycle. Its power is what the arm's drives follow: without it the arm stands where it is.
/// One thread.
class EmulatedRobot {
 public:
  /// @param plant  the arm @param clock  the controller's, against the machine's @param network  outlives the robot
  EmulatedRobot(const ControllerOptions& options, std::shared_ptr<const device::ArmDescription> arm,
                std::shared_ptr<device::ArmBackend> plant, hw::Network& network,
                const emulation::DeviceClock& clock = {});

  /// Opens its ports. @return why not. Realtime: setup.
  [[nodiscard]] Result<void> listen(std::uint32_t host);

  /// Once in each cycle of the plant: look(), serve(), tell(). @param now  of the machine's clock, growing
  void step(std::int64_t cycle, Nanoseconds now) {
    look();
    serve(now);
    tell(cycle, now);
  }
  /// Reads the arm.
  void look() {
    has_sample_ = plant_->read(sample_);
    if (terminals_) terminals_->read_inputs(controller_->io());
  }
  /// Takes what clients have sent, runs the frames that are due, and sends. May be called at any time. While the arm
  /// gives no sample the frames pass without anything being done or sent.
  void serve(Nanoseconds now);
  /// Tells the arm where to be.
  void tell(std::int64_t cycle, Nanoseconds now);
  /// What is behind its terminals: inputs are read with the arm, outputs written when it is told where to be.
  /// @param io  of a block that refuse_terminals() accepts. Realtime: setup.
  void set_terminals(const device::IoDescription& io, device::IoTerminals machine) {
    terminals_.emplace(io, std::move(machine));
  }
  /// When the next frame is due, on the machine's clock.
  [[nodiscard]] Nanoseconds next_frame() const { return clock_.to_core(next_frame_ * controller_->cycle()); }

  /// Power is cut and comes back: every connection breaks, its clock and its registers begin anew.
  void restart();

  [[nodiscard]] Controller& controller() { return *controller_; }
  [[nodiscard]] Front* front() { return front_.get(); }
  /// Closes, and opens, the brakes of the arm behind it; where there are none the arm stands by its drives.
  std::function<void()> close_brakes, open_brakes;

 private:
  void follow_power();
  void follow_plant();

  ControllerOptions options_;
  std::shared_ptr<const device::ArmDescription> arm_;
  std::shared_ptr<device::ArmBackend> plant_;
  hw::Network& network_;
  emulation::DeviceClock clock_;
  std::unique_ptr<Controller> controller_;
  std::unique_ptr<Front> front_;
  std::uint32_t host_ = 0;
  device::ArmSample sample_;
  bool has_sample_ = false, braked_ = false, plant_stopped_ = false;
  std::int64_t next_frame_;      // number of the device's cycle
  Nanoseconds frame_begin_ = 0;  // of the newest frame, on the device's clock
  std::optional<WiredTerminals> terminals_;
};

}  // namespace takt::hw::rtde
