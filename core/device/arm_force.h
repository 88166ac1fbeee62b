#pragma once

#include <memory>
#include <optional>

#include "core/device/arm.h"
#include "core/device/force_torque_sensor.h"

/// What an arm feels itself, as a force/torque sensor on its flange.
namespace takt::device {

/// The wrench w on the flange with J^T w = tau in the sense of least squares, in axes of the flange, N and Nm. Where J
/// has lost a direction nothing can be said.
/// @param tau  what the surroundings exert on the joints, Nm or N   @param[out] J  of the flange in the arm's base
/// Realtime: cyclic, O(n), no allocation.
[[nodiscard]] std::optional<net::Wrench> external_wrench(const kinematics::Chain& chain, const JointVector& q,
                                                         const JointVector& tau, kinematics::Jacobian& J);

/// The external torques that an arm estimates, as the reading of a sensor in its flange. They are as good as the arm
/// knows its own mass, friction and load: the offset of a wrong model is in them, and what is told as load is not. No
/// reading near singular postures, and from arms that estimate none. The arm comes before it in the cycle.
class ArmForce final : public ForceTorqueBackend {
 public:
  explicit ArmForce(const Arm& arm) : arm_(arm) {}
  bool read(WrenchSample& sample) override;

 private:
  const Arm& arm_;
  kinematics::Jacobian J_;
};

/// What is known of such a sensor: of the range and noise of the arm's own estimate nothing is declared.
[[nodiscard]] std::shared_ptr<const ForceTorqueDescription> arm_force_description(const ArmDescription& arm);

}  // namespace takt::device
