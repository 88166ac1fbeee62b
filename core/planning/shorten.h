#pragma once

#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "core/planning/free_space.h"

namespace takt::planning {

/// Shortens a free path of straight lines, as path_search.h measures it: leaves points out, and cuts between random
/// places of it, with all joints or with one. Ends stay. The path stays free.
/// Source: Geraerts, Overmars 2007 (shortcuts of one joint). @param looks  as in connect(). Realtime: setup,
/// deterministic.
void shorten(FreeSpace& space, std::vector<JointVector>& points, const JointVector& speed, Random& random,
             std::int64_t looks);

}  // namespace takt::planning
