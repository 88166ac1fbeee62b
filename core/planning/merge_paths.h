#pragma once

#include <cstdint>
#include <vector>

#include "core/planning/free_space.h"

namespace takt::planning {

/// The shortest way along several free paths of straight lines that begin at the same posture: it may change from one
/// to another where they are near to each other and the line between is free. Such lines are looked at only where they
/// would make it shorter. Source: Raveh, Enosh, Halperin 2011 (merging of paths).
/// @param paths  one at least, each with two points or more   @param looks  as in connect(): what is shortest so far
/// counts then
/// @return a free path from the common start to the end of one of them. Realtime: setup, deterministic.
[[nodiscard]] std::vector<JointVector> merge_paths(FreeSpace& space, const std::vector<std::vector<JointVector>>& paths,
                                                   const JointVector& speed, std::int64_t looks);

}  // namespace takt::planning
