#include "core/kinematics/link_path.h"

#include <algorithm>

namespace takt::kinematics {

using Eigen::Isometry3d;

Isometry3d LinkPath::pose(const JointVector& q) const {
  Isometry3d X = Isometry3d::Identity();
  for (const Step& step : steps_) {
    X = X * step.X_PJ;
    if (step.prismatic) {
      X.translate(q[step.joint] * step.axis);
    } else {
      X.rotate(Eigen::AngleAxisd(q[step.joint], step.axis));
    }
  }
  return X * X_JL_;
}

LinkPath::Motion LinkPath::motion(const JointVector& q, const JointVector& dq) const {
  const Isometry3d X_BL = pose(q);
  Vector6 V = Vector6::Zero();
  Isometry3d X = Isometry3d::Identity();
  for (const Step& step : steps_) {
    X = X * step.X_PJ;
    const Eigen::Vector3d axis_B = X.linear() * step.axis;
    const double rate = dq[step.joint];
    if (step.prismatic) {
      V.head<3>() += rate * axis_B;
      X.translate(q[step.joint] * step.axis);
    } else {
      V.head<3>() += rate * axis_B.cross(X_BL.translation() - X.translation());
      V.tail<3>() += rate * axis_B;
      X.rotate(Eigen::AngleAxisd(q[step.joint], step.axis));
    }
  }
  return {X_BL, V};
}

LinkPaths::LinkPaths(const RobotModel& model, const std::string& base_link, std::span<const std::string> joints) {
  std::map<std::string, LinkPath, std::less<>> known;  // those that stand still with the base, too
  known[base_link];
  for (const Joint& joint : model.joints) {  // parents come before their children
    const auto parent = known.find(joint.parent);
    if (parent == known.end()) continue;
    LinkPath path = parent->second;
    const auto number = std::ranges::find(joints, joint.name);
    if (joint.type == JointType::kFixed) {
      path.X_JL_ = path.X_JL_ * joint.X_PJ;
    } else if (number != joints.end()) {
      path.steps_.push_back({path.X_JL_ * joint.X_PJ, joint.axis, joint.type == JointType::kPrismatic,
                             static_cast<Eigen::Index>(number - joints.begin())});
      path.X_JL_.setIdentity();
    } else {
      continue;
    }
    known.emplace(joint.child, std::move(path));
  }
  for (auto& [link, path] : known)
    if (!path.steps_.empty()) paths_.emplace(link, std::move(path));
}

const LinkPath* LinkPaths::find(std::string_view link) const {
  const auto found = paths_.find(link);
  return found == paths_.end() ? nullptr : &found->second;
}

std::vector<std::string> LinkPaths::names() const {
  std::vector<std::string> names;
  for (const auto& [name, path] : paths_) names.push_back(name);
  return names;
}

}  // namespace takt::kinematics
