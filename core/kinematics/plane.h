#pragma once

#include "core/kinematics/chain.h"

namespace takt::kinematics {

/// Two sliding joints and then one that turns about the normal of their plane: a base that drives, not an arm that
/// cannot turn its tool freely. Realtime: setup.
[[nodiscard]] bool moves_in_plane(const Chain& chain);

}  // namespace takt::kinematics
