#pragma once

#include <optional>

#include "core/base/diagnostics.h"
#include "core/kinematics/chain.h"
#include "core/motion/limits.h"

namespace takt::motion {

/// Chooses the configuration in which a PTP motion ends whose goal is given as a pose: of all that put the flange
/// there and lie inside the ranges, the nearest to `q_near`.
/// @param weights  factor of each joint's distance; the default is one over its velocity limit, so that the distance is
/// about the time to go it
/// @return the configuration, or a diagnostic at `/goal`: out of reach, or reachable outside the ranges only.
/// Realtime: setup, deterministic.
[[nodiscard]] Result<JointVector> choose_solution(const kinematics::Chain& chain, const JointLimits& limits,
                                                  const Eigen::Isometry3d& X_BF, const JointVector& q_near,
                                                  const std::optional<JointVector>& weights = {});

}  // namespace takt::motion
