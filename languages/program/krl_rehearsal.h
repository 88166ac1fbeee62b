#pragma once

#include "core/program/tree/node.h"
#include "languages/krl/program.h"
#include "languages/program/krl_map.h"

namespace takt::languages {

/// Runs a program on nominal values: its motions are planned in the order in which it comes to them, waits take no time
/// that is not known. It ends, with a note, where a line has been played a hundred times.
void rehearse_krl(const krl::Program& krl, const KrlMap& map, const program::Node& node,
                  operations::Rehearsal& rehearsal, Diagnostics& diagnostics);

}  // namespace takt::languages
