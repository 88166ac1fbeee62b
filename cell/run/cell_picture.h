#pragma once

#include <filesystem>

#include "cell/build/built_cell.h"
#include "core/activity/motion_collisions.h"

namespace takt::cell {

/// Draws the cell of a rehearsal as a PNG of 1280x720: how it stands when two bodies collide, these two in red and
/// blue and all else in grey, seen from where both show best. Objects are where the program believes them to be.
/// @param collision  null: the cell at its start, in its own colours
/// @return diagnostics: a file that cannot be written, no graphics. Realtime: setup.
[[nodiscard]] Result<void> draw_cell(const BuiltCell& built, const activity::FoundCollision* collision,
                                     const std::filesystem::path& file);

}  // namespace takt::cell
