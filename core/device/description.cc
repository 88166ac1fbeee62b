#include "core/device/description.h"

#include "core/kinematics/robot_model.h"

namespace takt::device {

namespace {

/// Inertia of a point mass at `p` about the origin (Steiner's term).
Eigen::Matrix3d steiner(double mass, const Eigen::Vector3d& p) {
  return mass * (p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose());
}

/// Pose of each link in the root link, all movable joints at zero.
std::vector<Eigen::Isometry3d> link_poses(const kinematics::RobotModel& robot) {
  std::vector<Eigen::Isometry3d> poses{Eigen::Isometry3d::Identity()};
  for (const kinematics::Joint& joint : robot.joints) {
    std::size_t parent = 0;
    while (robot.links[parent].name != joint.parent) ++parent;
    poses.push_back(poses[parent] * joint.X_PJ);
  }
  return poses;
}

}  // namespace

PayloadSetting combine(const PayloadSetting& a, const PayloadSetting& b) {
  PayloadSetting sum;
  sum.mass = a.mass + b.mass;
  if (sum.mass <= 0.0) return sum;
  sum.p_FC = (a.mass * a.p_FC + b.mass * b.p_FC) / sum.mass;
  sum.I_C = a.I_C + b.I_C + steiner(a.mass, a.p_FC - sum.p_FC) + steiner(b.mass, b.p_FC - sum.p_FC);
  return sum;
}

PayloadSetting transform(const Eigen::Isometry3d& X_AM, const PayloadSetting& payload) {
  const Eigen::Matrix3d R = X_AM.linear();
  return {.mass = payload.mass, .p_FC = X_AM * payload.p_FC, .I_C = R * payload.I_C * R.transpose()};
}

PayloadSetting rigid_payload(const kinematics::RobotModel& robot) {
  const auto poses = link_poses(robot);
  PayloadSetting sum;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    const auto& inertial = robot.links[i].inertial;
    if (!inertial) continue;
    const PayloadSetting own{.mass = inertial->mass, .p_FC = Eigen::Vector3d::Zero(), .I_C = inertial->I_C};
    sum = combine(sum, transform(poses[i] * inertial->X_LC, own));
  }
  return sum;
}

}  // namespace takt::device
