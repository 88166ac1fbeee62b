#pragma once

#include "core/base/diagnostics.h"
#include "core/command/command.h"

namespace takt::command {

/// The rules C1 to C10 of docs/command-layer.md and what else makes a command impossible, all at once. Each diagnostic
/// names the location in the tree ("/screwing/handlers/0"), the rule, the value and what to do.
/// @param planned  false: actions that are not planned yet are no fault. Realtime: setup.
[[nodiscard]] Diagnostics check(const Command& command, bool planned = true);

/// Adds those of `more` that are not in `found` yet, at their location or below it. Realtime: setup.
void append_new(const Diagnostics& more, Diagnostics& found);

}  // namespace takt::command
