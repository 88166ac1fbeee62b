#pragma once

#include <memory>

#include "cell/file/description.h"
#include "core/collision/cell_shapes.h"
#include "core/expression/cell.h"
#include "sim/model/world_description.h"

namespace takt::cell {

/// The solids of a cell for checks of collisions: machines as they are simulated, objects and frames as the program
/// believes them to be, and what the file says of them ("collisions").
/// @param cell  with its devices, frames and objects
/// @return the shapes; diagnostics: unknown names in "allow"; warnings: meshes that cannot be used. Realtime: setup.
[[nodiscard]] std::shared_ptr<const collision::CellShapes> cell_shapes(const Description& description,
                                                                       const sim::WorldDescription& simulated,
                                                                       const expression::Cell& cell,
                                                                       Diagnostics& diagnostics);

}  // namespace takt::cell
