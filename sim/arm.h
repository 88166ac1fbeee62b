#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/base/random.h"
#include "core/device/backend.h"
#include "core/kinematics/chain.h"
#include "sim/device.h"
#include "sim/joint_drive.h"
#include "sim/world_description.h"

namespace takt::sim {

/// Why a simulated arm closed its brakes by itself (ArmSample::fault).
enum class ArmFault : std::uint32_t {
  kNone = 0,
  kSetPointInvalid = 1,  ///< not finite or of the wrong size
  kFollowingError = 2,   ///< a joint is too far from its set point
  kOverspeed = 3,        ///< a joint is faster than the controller allows
};

/// What the world hands to an arm when it is built.
struct ArmPlant {
  kinematics::Chain chain;
  std::array<int, kinematics::kMaxJoints> position_address{};  ///< of each joint in the plant's position vector
  std::array<int, kinematics::kMaxJoints> velocity_address{};
  JointVector armature = {};
  JointVector coulomb = {};
  JointVector viscous = {};
  Eigen::Vector3d gravity_B = Eigen::Vector3d::Zero();
  double timestep = 0.001;              ///< s
  device::PayloadSetting payload = {};  ///< told to the controller
};

/// An arm in MuJoCo with its controller: computed torque in joint space from the URDF (row D6).
///   tau = M(q) a + C(q, dq) dq + g(q) + armature a + compensated friction,
///   a = ddq_r + 2 d w (dq_r - dq) + w^2 (q_r - q), clipped to the effort limits of the URDF.
/// It runs before each physics step, as joint loops are faster than the cycle, and extrapolates the set point within
/// the cycle by its dq and ddq. A set point written in cycle k acts from the step of cycle k on; in a cycle without
/// one the arm holds the last position. Joint torque sensors sit behind the gears: they read the motor torque less
/// friction and less what accelerates the rotor, one physics step older than the positions beside them.
/// Owned by its World. Thread: the one that steps the world. Realtime: cyclic but for the constructor.
class SimArm final : public device::ArmBackend, public SimDevice {
 public:
  SimArm(const SimArmDescription& description, ArmPlant plant, std::uint64_t seed);

  bool read(device::ArmSample& sample) override;
  void write(const device::ArmSetPoint& set_point) override;
  /// The controller believes it, the plant does not change.
  void set_payload(const device::PayloadSetting& payload) override;
  void brake() override;
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override;

  /// What the operator does at the panel: forgets the fault, opens the brakes, holds where the arm is.
  void release_brakes();
  [[nodiscard]] bool braked() const { return braked_; }
  [[nodiscard]] const kinematics::Chain& chain() const { return plant_.chain; }
  [[nodiscard]] const kinematics::Payload& payload() const { return payload_; }
  /// Motor torque of the last physics step, Nm.
  [[nodiscard]] const JointVector& motor_torque() const { return motor_torque_; }

  void start(const mjData_& data) override;
  void actuate(mjData_& data, int substep) override;
  void measure(const mjData_& data, Nanoseconds now) override;
  void stream(StateStream& state) override;

 private:
  void gather(const mjData_& data);
  void compute_torque(double time_in_cycle);
  void supervise();
  void trip(ArmFault fault);

  ArmControlParameters control_;
  ArmMeasurement measurement_;
  JointVector torque_offset_;
  double payload_mass_error_ = 0.0;
  ArmPlant plant_;
  kinematics::Payload payload_;  // as the controller believes
  JointDrives drives_;
  Random noise_;

  JointVector q_, dq_;            // as measured by the controller
  JointVector q_true_, dq_true_;  // of the plant
  JointVector motor_torque_;
  JointVector joint_torque_;  // behind the gear
  device::ArmSetPoint set_point_;
  bool fresh_set_point_ = false;  // written since the last cycle
  bool braked_ = false;
  std::uint32_t fault_ = 0;
  device::ArmSample sample_;
};

}  // namespace takt::sim
