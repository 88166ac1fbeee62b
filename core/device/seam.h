#pragma once

#include <optional>

#include "core/device/backend.h"
#include "core/net/value.h"

namespace takt::device {

/// How a net takes a device over, or leaves it: the set point before its first cycle, or of its last one (row L3).
/// What is not said is not compared.
struct Seam {
  JointVector q = {}, dq = {}, ddq = {};  ///< rad, rad/s, rad/s^2 or the same in m; size 0: not said
  net::Text mode = {};                    ///< control mode; empty: not said
  std::optional<ToolSetting> tool = {};
};

}  // namespace takt::device
