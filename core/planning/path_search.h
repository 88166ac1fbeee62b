#pragma once

#include <optional>

#include "core/planning/path_query.h"

namespace takt::planning {

/// A free path that is as short as the effort allows: the straight line where that is free, else the best of several
/// random trees, each shortened. The same query gives the same bits; no clock has a say.
/// @return nothing: none was found with that many looks. Realtime: setup.
[[nodiscard]] std::optional<FoundPath> find_path(FreeSpace& space, const Query& query);

}  // namespace takt::planning
