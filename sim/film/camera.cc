#include "sim/model/world_description.h"

namespace takt::sim {

Pose look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up) {
  const Eigen::Vector3d back = (eye - target).normalized();
  // Looking straight along `up`, any direction across serves.
  Eigen::Vector3d right = up.cross(back);
  if (right.norm() < 1e-9) right = back.unitOrthogonal();
  right.normalize();
  Pose X = Pose::Identity();
  X.linear() << right, back.cross(right), back;
  X.translation() = eye;
  return X;
}

}  // namespace takt::sim
