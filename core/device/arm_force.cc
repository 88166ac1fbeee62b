#include "core/device/arm_force.h"

#include <Eigen/Cholesky>

#include "core/kinematics/chain.h"

namespace takt::device {

std::optional<net::Wrench> external_wrench(const kinematics::Chain& chain, const JointVector& q, const JointVector& tau,
                                           kinematics::Jacobian& J) {
  constexpr double kLeastPivot = 1e-3;  // a direction in which a joint's rad moves the flange by 3 cm or rad
  Eigen::Isometry3d X_BF;
  chain.jacobian(q, X_BF, J);
  const Eigen::Matrix<double, 6, 6> JJ = J * J.transpose();
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(JJ);
  if (!(solver.vectorD().minCoeff() > kLeastPivot)) return std::nullopt;
  const kinematics::Vector6 w = solver.solve(J * tau);
  const Eigen::Matrix3d R_FB = X_BF.linear().transpose();
  return net::Wrench{.force = R_FB * w.head<3>(), .torque = R_FB * w.tail<3>()};
}

bool ArmForce::read(WrenchSample& sample) {
  const ArmSample& felt = arm_.sample();
  if (!arm_.has_sample() || felt.tau_external.size() != arm_.joint_count()) return false;
  const auto wrench = external_wrench(*arm_.description().chain, felt.q, felt.tau_external, J_);
  if (!wrench) return false;
  sample = {.sequence = felt.sequence, .stamp = felt.stamp, .wrench = *wrench};
  return true;
}

std::shared_ptr<const ForceTorqueDescription> arm_force_description(const ArmDescription& arm) {
  ForceTorqueDescription sensor;
  sensor.title = "external torques of the arm";
  sensor.model = arm.model;
  sensor.mount_link = sensor.measuring_link = sensor.tool_link = arm.flange_link;
  sensor.robot = arm.robot;
  sensor.cycle = arm.cycle;
  sensor.sample_age_max = arm.sample_age_max;
  return std::make_shared<const ForceTorqueDescription>(std::move(sensor));
}

}  // namespace takt::device
