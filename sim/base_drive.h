#pragma once

#include <array>
#include <string>

#include "core/base/random.h"
#include "core/kinematics/types.h"
#include "core/kinematics/wheel_drive.h"
#include "sim/device.h"
#include "sim/world_description.h"

struct mjData_;

namespace takt::sim {

/// What lies between the joints x, y, yaw of a simulated base and its controller: odometry that counts wrong, forces
/// that act where the body really points, and wheels that turn with the motion. The wheels do not carry and do not
/// push: the body slides in its plane (docs/devices/base.md). Thread: one. Realtime: cyclic but for the constructor.
class BaseDrive {
 public:
  struct Wheel {
    int velocity_address = 0;
    double inertia = 0.0;  ///< about its axle, kg m^2
  };
  using Wheels = std::array<Wheel, kinematics::MecanumDrive::kWheels>;

  /// @param name  of the device: its stream of random numbers   @param timestep  of the physics, s
  BaseDrive(const SimDriveDescription& description, const Wheels& wheels, double timestep, std::uint64_t seed,
            const std::string& name);

  /// The odometry counts from here, and is right.
  void start(const JointVector& q_true);
  /// Counts the way since the last call. @param[out] q, dq  what the odometry says (x, y, yaw)
  void count(const JointVector& q_true, const JointVector& dq_true, JointVector& q, JointVector& dq);
  /// Forces that the controller wants in the axes of its odometry, as they act on the plant.
  [[nodiscard]] JointVector on_plant(const JointVector& force) const;
  /// The wheels turn as the body moves, without slip.
  void turn_wheels(mjData_& data, const JointVector& q_true, const JointVector& dq_true) const;

  void stream(StateStream& state);

 private:
  [[nodiscard]] bool exact() const;

  SimDriveDescription description_;
  Wheels wheels_;
  double timestep_;
  Random noise_;
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();     ///< true place at the last count
  Eigen::Vector3d counted_ = Eigen::Vector3d::Zero();  ///< what the odometry made of it
};

}  // namespace takt::sim
