#pragma once

#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/kinematics/types.h"
#include "core/kinematics/wheel_drive.h"
#include "sim/model/device.h"
#include "sim/model/world_description.h"

struct mjData_;

namespace takt::sim {

/// What lies between the joints x, y, yaw of a simulated base and its controller: odometry that counts wrong, forces
/// that act where the body really points, and wheels that turn with the motion. The wheels do not carry and do not
/// push: the body slides in its plane (docs/devices/base.md). Two wheels on an axle (differential drive) push ahead
/// and turn only; sideways their tyres hold like springs until they slip, and the odometry sees nothing of it. Such a
/// base is steered back to its line while it drives. Thread: one. Realtime: cyclic but for the constructor.
class BaseDrive {
 public:
  struct Wheel {
    int velocity_address = 0;
    double inertia = 0.0;  ///< about its axle, kg m^2
  };
  using Wheels = std::vector<Wheel>;

  /// @param name  of the device: its stream of random numbers
  BaseDrive(const SimDriveDescription& description, Wheels wheels, std::uint64_t seed, const std::string& name);

  /// The odometry counts from here, and is right.
  void start(const JointVector& q_true);
  /// Counts the way since the last call. @param[out] q, dq  what the odometry says (x, y, yaw)
  void count(const JointVector& q_true, const JointVector& dq_true, JointVector& q, JointVector& dq);
  /// Turns the wanted heading towards a line beside which the base drives; nothing for a base that goes sideways.
  /// @param q  where it believes to be   @param dq_r  wanted speed   @param[in,out] q_r  wanted place
  void steer(const JointVector& q, const JointVector& dq_r, JointVector& q_r) const;
  /// Forces that the controller wants in the axes of its odometry, as they act on the plant in this physics step.
  [[nodiscard]] JointVector on_plant(const JointVector& force, const JointVector& q_true, const JointVector& dq_true,
                                     double duration);
  /// What acts on a base that is held by such forces on the joints of the plant: sideways its tyres hold it, if it has
  /// any.
  [[nodiscard]] JointVector held(const JointVector& force, const JointVector& q_true, const JointVector& dq_true,
                                 double duration);
  /// The wheels turn as the body moves, without slip.
  void turn_wheels(mjData_& data, const JointVector& q_true, const JointVector& dq_true, double duration) const;

  void stream(StateStream& state);

 private:
  [[nodiscard]] bool exact() const;
  [[nodiscard]] const kinematics::DifferentialDrive* differential() const;
  /// Of the tyres against the body's left, N; a spring from where they last slipped to.
  [[nodiscard]] double tyre_force(const kinematics::DifferentialDrive& drive, double speed_left, double duration);

  SimDriveDescription description_;
  Wheels wheels_;
  Random noise_;
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();     ///< true place at the last count
  Eigen::Vector3d counted_ = Eigen::Vector3d::Zero();  ///< what the odometry made of it
  double deflection_ = 0.0;                            ///< of the tyres to the left, m
};

}  // namespace takt::sim
