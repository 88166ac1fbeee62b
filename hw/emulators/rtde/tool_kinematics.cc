#include "hw/emulators/rtde/tool_kinematics.h"

#include <Eigen/LU>

#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/solutions.h"

namespace takt::hw::rtde {

namespace {

constexpr double kDamping = 0.02;  // of the Jacobian's inverse: singular values below it are not followed

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// (J J^T + d^2)^-1 x
Vector6 damped(const kinematics::Jacobian& J, const Vector6& x) {
  const Matrix6 A = J * J.transpose() + kDamping * kDamping * Matrix6::Identity();
  return A.partialPivLu().solve(x);
}

}  // namespace

Eigen::Isometry3d ToolKinematics::X_BF(const JointVector& q) const { return arm_->chain->forward(q); }
Eigen::Isometry3d ToolKinematics::X_BT(const JointVector& q) const { return X_BF(q) * X_FT_; }

kinematics::Jacobian ToolKinematics::jacobian(const JointVector& q) const {
  Eigen::Isometry3d X;
  kinematics::Jacobian J;
  arm_->chain->jacobian(q, X, J);
  const Eigen::Vector3d p_FT_B = X.linear() * X_FT_.translation();
  for (int i = 0; i < J.cols(); ++i) {
    const Eigen::Vector3d w = J.col(i).tail<3>();
    J.col(i).head<3>() += w.cross(p_FT_B);
  }
  return J;
}

Vector6 ToolKinematics::twist(const JointVector& q, const JointVector& dq) const { return jacobian(q) * dq; }

JointVector ToolKinematics::rates(const JointVector& q, const Vector6& V_BT_B) const {
  const kinematics::Jacobian J = jacobian(q);
  return J.transpose() * damped(J, V_BT_B);
}

Vector6 ToolKinematics::wrench(const JointVector& q, const JointVector& tau_external) const {
  const kinematics::Jacobian J = jacobian(q);
  if (tau_external.size() != J.cols()) return Vector6::Zero();
  return damped(J, J * tau_external);
}

bool ToolKinematics::solve(const Eigen::Isometry3d& X_BT, JointVector& q) const {
  return arm_->inverse->solve(X_BT * X_FT_.inverse(), {}, q) == kinematics::IkStatus::kOk;
}

std::optional<JointVector> ToolKinematics::nearest_solution(const Eigen::Isometry3d& X_BT,
                                                            const JointVector& near) const {
  kinematics::SolutionOptions options;
  options.reference = near;
  options.turns = false;
  options.most = 1;
  const auto solutions = kinematics::inverse_solutions(*arm_->chain, X_BT * X_FT_.inverse(), options);
  if (solutions.empty()) return std::nullopt;
  return solutions.front();
}

}  // namespace takt::hw::rtde
