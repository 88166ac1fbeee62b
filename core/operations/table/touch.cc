#include "core/operations/table/touch.h"

#include <fmt/format.h>

namespace takt::operations {

Diagnostics note_touch(activity::Context& context, const std::string& arm, const Eigen::Isometry3d& X_BT) {
  const auto X_WB = context.cell.frames.pose(arm);
  if (!X_WB) return X_WB.error();
  return note_touch_in_room(context, arm, *X_WB * X_BT);
}

Diagnostics note_touch_in_room(activity::Context& context, const std::string& arm, const Eigen::Isometry3d& X_WT) {
  const Eigen::Vector3d p_W = X_WT.translation();
  context.variables.touches[arm] = {p_W, context.cell.arms.find(arm)->second.tip.ball_radius, context.core.cycle()};
  context.event(arm, "touch", fmt::format("({:.5f}, {:.5f}, {:.5f}) m", p_W.x(), p_W.y(), p_W.z()));
  return {};
}

}  // namespace takt::operations
