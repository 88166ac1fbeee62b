#include "core/device/link_pose.h"

namespace takt::device {

Eigen::Isometry3d pose_between(const kinematics::RobotModel& robot, const std::string& from, const std::string& to) {
  const auto to_root = [&robot](const std::string& link) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    for (const auto* joint = robot.joint_above(link); joint != nullptr; joint = robot.joint_above(joint->parent))
      X = joint->X_PJ * X;
    return X;
  };
  return to_root(from).inverse() * to_root(to);
}

}  // namespace takt::device
