#include "core/kinematics/plane.h"

namespace takt::kinematics {

bool moves_in_plane(const Chain& chain) {
  if (chain.joint_count() != 3) return false;
  Eigen::Isometry3d X;
  Jacobian J;
  chain.jacobian(JointVector::Zero(3), X, J);
  constexpr double kSquare = 1e-9;
  const auto slides = [&](int joint) { return J.col(joint).tail<3>().norm() < kSquare; };
  const Eigen::Vector3d normal = J.col(0).head<3>().cross(J.col(1).head<3>());
  return slides(0) && slides(1) && normal.norm() > kSquare && !slides(2) &&
         normal.normalized().cross(J.col(2).tail<3>()).norm() < kSquare;
}

}  // namespace takt::kinematics
