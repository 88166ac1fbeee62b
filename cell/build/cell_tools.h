#pragma once

#include "cell/build/device_kind.h"

namespace takt::cell {

/// The tools of a cell and the tool of each arm that counts where a step names none: the only one, or the one that the
/// file declares; with several tools and no declaration there is a diagnostic that says what to write. Realtime: setup.
void add_tools(LoadedDevices devices, expression::Cell& cell, Diagnostics& diagnostics);

}  // namespace takt::cell
