#pragma once

#include <string>

#include "core/activity/context.h"

namespace takt::operations {

/// Takes note of where the tool of an arm touched: its last touch, and an event. Diagnostics: it is unknown
/// where the arm is. @param X_BT  of the tool centre point in the arm's base, m. Realtime: setup.
[[nodiscard]] Diagnostics note_touch(activity::Context& context, const std::string& arm, const Eigen::Isometry3d& X_BT);
/// The same with the tool centre point in the world, m: of an arm whose base may have moved on since.
[[nodiscard]] Diagnostics note_touch_in_room(activity::Context& context, const std::string& arm,
                                             const Eigen::Isometry3d& X_WT);

}  // namespace takt::operations
