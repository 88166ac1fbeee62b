#pragma once

#include "core/command/actions/online_action.h"

namespace takt::command {

/// Manual control of single joints: they go at wanted rates, rad/s or m/s, while a dead-man switch is held. When the
/// switch falls, does not answer, or the rates are not there, the arm comes to rest within its limits. Rates with which
/// the tool would be faster than `bounds` are made smaller by one factor, and by their `speed` and that of the
/// actuator. Realtime: setup.
[[nodiscard]] Action jog(const expression::JointsSensor& rates, const expression::State& enabled,
                         const TrackingParameters& bounds = {});

}  // namespace takt::command
