#pragma once

#include "core/net/flat_net.h"
#include "core/net/net_report.h"

namespace takt::net {

/// The reaction certificate (rows O6, O7): for each source (a primitive whose outputs come from outside the net) and
/// each sink it reaches (inputs of terminations, of primitives that drive a device, of monitors, and inputs that stop)
/// the fewest and most cycles between an event at the source and its arrival at the sink, and the critical path.
///
/// The fewest come by the shortest way. The most come by the longest way that passes no port twice: exact outside
/// loops and in loops of moderate size, an upper bound in tangled ones. A way through a latency that depends on data
/// is marked: its cycles are a lower bound of the most. Links into `active` count: what switches a fragment reaches
/// all its outputs.
/// For nets without errors. A net with very many sources gets a note instead. Realtime: setup, O(sources * links).
void certify_reactions(const FlatNet& flat, NetReport& net_report, LoadReport& report);

/// Holds the net to the bounds that it demands of itself: each that is broken, cannot be shown or depends on data is an
/// error with the way that breaks it. For nets whose links are sound. Realtime: setup, O(demands * links).
void check_demands(const FlatNet& flat, NetReport& net_report, LoadReport& report);

}  // namespace takt::net
