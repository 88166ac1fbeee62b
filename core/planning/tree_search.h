#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/planning/path_query.h"

namespace takt::planning {

/// A free path, by two random trees that grow towards each other (RRT-Connect). What is random comes from `random`.
/// Source: Kuffner, LaValle 2000; implementation: OMPL.
/// @param shorter_than  s: postures through which no path of this length leads are not drawn
/// @param looks  the search ends when the space has been looked at that often
/// @return points from the start to a goal; nothing: none was found. Realtime: setup, deterministic.
[[nodiscard]] std::optional<std::vector<JointVector>> connect(FreeSpace& space, const Query& query, double shorter_than,
                                                              Random& random, std::int64_t looks);

}  // namespace takt::planning
