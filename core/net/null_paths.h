#pragma once

#include "core/net/flat_net.h"

namespace takt::net {

/// Notes where null can reach an input that drives or stops something (rows N3, N4): each with the shortest path from
/// where the null arises. Null arises at outputs that say so, at delayed links without an initial value, at constants
/// null, and at the outputs of a fragment that rests; it passes primitives whose inputs propagate it. For nets without
/// errors. Realtime: setup, linear.
void note_null_paths(const FlatNet& flat, LoadReport& report);

}  // namespace takt::net
