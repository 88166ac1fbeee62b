#pragma once

#include <array>
#include <optional>

#include "core/device/backend.h"
#include "core/kinematics/chain.h"
#include "sim/machines/base_drive.h"
#include "sim/machines/joint_drive.h"
#include "sim/model/device.h"
#include "sim/model/world_description.h"

namespace takt::sim {

/// What the world hands to an arm when it is built.
struct ArmPlant {
  kinematics::Chain chain;
  std::array<int, kinematics::kMaxJoints> position_address{};  ///< of each joint in the plant's position vector
  std::array<int, kinematics::kMaxJoints> velocity_address{};
  int root = 0;  ///< the plant's number of the first body that the joints move
  JointVector armature = {};
  JointVector coulomb = {};
  JointVector viscous = {};
  Eigen::Vector3d gravity_B = Eigen::Vector3d::Zero();
  double timestep = 0.001;              ///< s
  double period = 0.001;                ///< of the world's cycle, s
  device::PayloadSetting payload = {};  ///< told to the controller
  std::optional<BaseDrive> drive = {};  ///< of a mobile base
};

/// What the law of an arm knows when it computes: what the drives measure and what they are told.
struct ArmTask {
  const JointVector& q;
  const JointVector& dq;
  JointVector q_r, dq_r, ddq_r;  ///< set point at this instant
  const device::Compliance& compliance;
  const kinematics::Payload& payload;  ///< as the controller believes
  const Eigen::Isometry3d& X_FT;       ///< tool centre point as it was told
};

/// The laws by which a simulated arm follows its set points (docs/simulation.md, "The controller"): all compute from
/// the URDF's chain and see only what is measured (row D6). Thread: one. Realtime: cyclic.
class ArmLaw {
 public:
  ArmLaw(const ArmControlParameters& control, const ArmPlant& plant, const JointDrives& drives)
      : control_(control), plant_(plant), drives_(drives) {}

  /// Torques of the motors for the mode of `task.compliance`, Nm; not yet clipped.
  [[nodiscard]] JointVector torque(const ArmTask& task) const;

 private:
  [[nodiscard]] JointVector position(const ArmTask& task) const;
  [[nodiscard]] JointVector joint_impedance(const ArmTask& task) const;
  [[nodiscard]] JointVector cartesian_impedance(const ArmTask& task) const;
  /// What moves the arm with the acceleration of the set point and carries it, and the friction of its motion.
  [[nodiscard]] JointVector dynamics(const ArmTask& task) const;
  /// Inertia of all joints with their rotors, kg m^2.
  [[nodiscard]] kinematics::JointMatrix inertia(const ArmTask& task) const;

  const ArmControlParameters& control_;
  const ArmPlant& plant_;
  const JointDrives& drives_;
};

/// Torques that the surroundings exert on the joints, from what the arm measures: an observer of its momentum. With
/// acceleration a = step of the measured velocity, r += gain h (M a + C dq + g - torque - r), which is the momentum
/// observer of De Luca and Mattone (2003) in steps. Thread: one. Realtime: cyclic.
class ExternalTorqueObserver {
 public:
  explicit ExternalTorqueObserver(int joint_count);
  /// @param inertial  M a + C dq + g for a = acceleration(); @param torque  measured, without friction and rotors
  /// @param gain      (n) 1/s
  void update(const JointVector& inertial, const JointVector& torque, const JointVector& gain, double h);
  /// Of the step from the last velocity to this one, rad/s^2; 0 in the first step after a reset.
  [[nodiscard]] JointVector acceleration(const JointVector& dq, double h);
  void reset();
  [[nodiscard]] const JointVector& estimate() const { return estimate_; }
  void stream(StateStream& state);

 private:
  JointVector estimate_, last_dq_;
  bool begun_ = false;
};

}  // namespace takt::sim
