#pragma once

#include <memory>
#include <optional>

#include <Eigen/Geometry>

#include "core/device/description.h"
#include "core/kinematics/types.h"
#include "hw/emulators/rtde/language.h"

namespace takt::hw::rtde {

using kinematics::JointVector;
using kinematics::Vector6;

/// Where the tool centre point T is, and how it is moved; B is the controller's frame "base".
class ToolKinematics {
 public:
  explicit ToolKinematics(std::shared_ptr<const device::ArmDescription> arm) : arm_(std::move(arm)) {}

  /// Pose of T on the flange. Realtime: cyclic, as all but nearest_solution().
  void set_tool(const Eigen::Isometry3d& X_FT) { X_FT_ = X_FT; }
  [[nodiscard]] const Eigen::Isometry3d& tool() const { return X_FT_; }
  [[nodiscard]] const device::ArmDescription& arm() const { return *arm_; }

  [[nodiscard]] Eigen::Isometry3d X_BT(const JointVector& q) const;
  [[nodiscard]] Eigen::Isometry3d X_BF(const JointVector& q) const;
  /// Velocity of T's origin and angular velocity, in axes of B.
  [[nodiscard]] Vector6 twist(const JointVector& q, const JointVector& dq) const;
  /// Joint velocities for a twist of T; damped near singular postures.
  [[nodiscard]] JointVector rates(const JointVector& q, const Vector6& V_BT_B) const;
  /// What the surroundings exert on the tool at T, from what they exert on the joints, in axes of B: N and Nm. Zero
  /// without an estimate of it.
  [[nodiscard]] Vector6 wrench(const JointVector& q, const JointVector& tau_external) const;
  /// On the branch of the seed. @return false: out of reach or singular; `q` is untouched then
  [[nodiscard]] bool solve(const Eigen::Isometry3d& X_BT, JointVector& q) const;
  /// Of all branches the joint positions nearest to `near`, within the joints' ranges. Realtime: setup.
  [[nodiscard]] std::optional<JointVector> nearest_solution(const Eigen::Isometry3d& X_BT,
                                                            const JointVector& near) const;

 private:
  [[nodiscard]] kinematics::Jacobian jacobian(const JointVector& q) const;

  std::shared_ptr<const device::ArmDescription> arm_;
  Eigen::Isometry3d X_FT_ = Eigen::Isometry3d::Identity();
};

}  // namespace takt::hw::rtde
