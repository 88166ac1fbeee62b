#pragma once

#include <optional>

#include "core/motion/path.h"

namespace takt::motion {

/// The same path of the same frame, place by place of s, as another arm sees it that moves the frame too.
/// @param X_AB  base B of the path, seen from the base A of the other arm   @param held  the held joints of the other
/// arm, which stay   @return nothing for a path with pieces in joints. Realtime: setup.
[[nodiscard]] std::optional<Path> seen_from(const Path& path, const Eigen::Isometry3d& X_AB, const JointVector& held);

}  // namespace takt::motion
