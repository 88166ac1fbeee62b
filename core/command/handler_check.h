#pragma once

#include "core/base/diagnostics.h"
#include "core/command/command_tree.h"

namespace takt::command {

/// Handlers that can never act (rule C11 of docs/command-layer.md): errors; and, as notes, starts for which their
/// transaction waits until a sensor triggers them (row L9 of docs/semantics.md). Part of check(). Realtime: setup.
void check_acting(const CommandTree& tree, Diagnostics& diagnostics);

}  // namespace takt::command
