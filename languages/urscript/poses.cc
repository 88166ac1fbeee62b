#include "languages/urscript/poses.h"

#include "core/motion/rotation_vector.h"

namespace takt::languages::urscript {

Eigen::Isometry3d to_isometry(const Pose& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(pose[0], pose[1], pose[2]);
  X.linear() = motion::exp_rotation(Eigen::Vector3d(pose[3], pose[4], pose[5]));
  return X;
}

Pose to_pose(const Eigen::Isometry3d& X) {
  const Eigen::Vector3d p = X.translation(), r = motion::log_rotation(X.linear());
  return {p.x(), p.y(), p.z(), r.x(), r.y(), r.z()};
}

}  // namespace takt::languages::urscript
