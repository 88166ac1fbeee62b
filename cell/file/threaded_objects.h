#pragma once

#include "cell/file/description.h"
#include "core/device/screw_thread.h"
#include "sim/model/world_description.h"

namespace takt::cell {

/// The description with the sizes that models/threads.json gives: radius and chamfer of bores with a thread or a
/// clearance; shapes, mass, material and the grasp "socket" of screws. Diagnostics: sizes that are not in the table.
/// Realtime: setup.
[[nodiscard]] Description with_threads(const Description& description, const device::ModelLibrary& models,
                                       Diagnostics& diagnostics);

/// What makes a completed object a screw in the simulation, or a bolt if it is fixed. Nothing: it is none.
/// Realtime: setup.
[[nodiscard]] std::optional<sim::ScrewDescription> simulated_screw(const ObjectEntry& entry);

}  // namespace takt::cell
