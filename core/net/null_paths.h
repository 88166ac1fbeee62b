#pragma once

#include "core/net/flat_net.h"
#include "core/net/net_report.h"

namespace takt::net {

/// Notes and lists where null can reach an input that drives or stops something (rows N3, N4): each with the shortest
/// path from where the null arises. Null arises at outputs that say so, at delayed links without an initial value, at
/// constants null, and at the outputs of a fragment that rests; it passes primitives whose inputs propagate it or may
/// let it pass. Marks the links by which null can come. For nets without errors whose links are in the report already.
/// Realtime: setup, linear.
void note_null_paths(const FlatNet& flat, NetReport& net_report, LoadReport& report);

}  // namespace takt::net
