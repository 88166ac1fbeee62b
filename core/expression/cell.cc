#include "core/expression/cell.h"

namespace takt::expression {

motion::ArmModel planning_model(const MountedArm& arm, const std::optional<Eigen::Isometry3d>& X_FM,
                                const std::optional<device::ToolSetting>& tool) {
  const device::ArmDescription& d = arm.device->description();
  const device::PayloadSetting carried = tool.value_or(arm.tool()).payload;
  return {
      .chain = *d.chain,
      .inverse = d.inverse.get(),
      .limits = d.limits,
      .cartesian = d.cartesian,
      .X_FM = X_FM.value_or(arm.X_FT),
      .load = motion::DriveLoad{
          .armature = d.armature, .gravity_B = arm.gravity_B, .payload = {carried.mass, carried.p_FC, carried.I_C}}};
}

Eigen::Isometry3d tool_pose(const MountedArm& arm, const kinematics::JointVector& q) {
  return arm.device->description().chain->forward(q) * arm.X_FT;
}

}  // namespace takt::expression
