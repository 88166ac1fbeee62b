#pragma once

#include "core/activity/motion_collisions.h"

/// Motions of which it shows in the run only when one begins after the other (docs/world.md). Realtime: setup.
namespace takt::operations {

/// Notes where two motions of different machines would meet if they were carried out at times that fit: whatever one
/// sweeps against whatever the other does. One note for each pair of machines or objects.
/// @param begin  the cell when the first of them begins
void note_possible_meetings(const expression::Cell& cell, const collision::CellState& begin,
                            const activity::CheckedMotion& a, const activity::CheckedMotion& b,
                            Diagnostics& diagnostics);

}  // namespace takt::operations
