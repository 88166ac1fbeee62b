#pragma once

#include "cell/build/built_cell.h"
#include "cell/file/description.h"

namespace takt::cell {

/// Builds a cell. @return it, or all diagnostics with pointers into the scenario file: unknown models, frames, devices,
/// start positions outside limits, and what the simulation finds. Warnings go to `warnings`. Realtime: setup.
[[nodiscard]] Result<BuiltCell> build_cell(const Description& description, const device::ModelLibrary& models,
                                           bool measure_times, Diagnostics& warnings);

/// What can be said of a cell that has errors of form already: models, mounts and frames that do not exist.
[[nodiscard]] Diagnostics check_cell_names(const Description& description, const device::ModelLibrary& models);

/// The names of a cell without anything behind them: enough to check the form of a program when the cell cannot be
/// built. A device whose model is not known counts as an arm if it stands in the room, else as a sensor.
[[nodiscard]] expression::Cell names_of_cell(const Description& description, const device::ModelLibrary& models);

}  // namespace takt::cell
