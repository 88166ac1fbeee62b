#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/device/gripper.h"
#include "sim/model/device.h"
#include "sim/model/world_description.h"

namespace takt::sim {

/// A parallel gripper in MuJoCo with its controller. Two fingers, coupled as by one drive; what they hold they hold by
/// friction alone: a grip that is too weak drops the part.
///   free:     the width follows a trapezoid profile to the wanted width, a = w^2 (width_r - width) + 2 w (speed_r -
///             speed), force clipped at the wanted one;
///   stalled:  standing off its goal for 30 ms, the drive presses with the wanted force: a part is held;
///   lost:     while holding, the fingers went on by more than 1.5 mm: the part is gone, the fingers go to their goal.
/// Owned by its World. Thread: the one that steps the world. Realtime: cyclic but for the constructor.
class SimGripper final : public device::GripperBackend, public SimDevice {
 public:
  /// Where the two finger joints are in the plant's vectors.
  struct Plant {
    std::array<int, 2> position_address{};
    std::array<int, 2> velocity_address{};
  };

  SimGripper(const SimGripperDescription& description, const Plant& plant) : figures_(description), plant_(plant) {}

  bool read(device::GripperSample& sample) override;
  void write(const device::GripperSetPoint& set_point) override;

  void start(const mjData_& data) override;
  void actuate(mjData_& data, const Substep& step) override;
  void measure(const mjData_& data, Nanoseconds now) override;
  void stream(StateStream& state) override;

 private:
  [[nodiscard]] double finger_mass() const { return figures_.finger_mass + figures_.finger_inertia; }
  void gather(const mjData_& data);
  void follow_profile(double duration);
  void watch(double duration);
  [[nodiscard]] double drive_force() const;

  SimGripperDescription figures_;
  Plant plant_;
  device::GripperSetPoint command_;
  bool commanded_ = false;  ///< a first command has come

  double width_ = 0.0, speed_ = 0.0;  // of the plant
  double width_reference_ = 0.0, speed_reference_ = 0.0, acceleration_reference_ = 0.0;
  double force_ = 0.0;       // of the last physics step, positive opens
  double held_width_ = 0.0;  // when the part was caught
  double still_ = 0.0;       // s, how long the fingers have stood off their goal
  device::GripperState state_ = device::GripperState::kIdle;
  device::GripperSample sample_;
};

}  // namespace takt::sim
