#pragma once

#include "core/base/diagnostics.h"
#include "core/net/flat_net.h"
#include "core/net/net_report.h"

namespace takt::net {

/// Solves the units of all links at once (row U1): every unit variable of every primitive is an unknown, every link
/// says that two products of powers are equal. Reports each link that contradicts the others with both ends and their
/// units; units that nothing fixes are dimensionless, with a note and an entry of `free_units`. Realtime: setup, near
/// linear in the number of links; the rare part that needs elimination has a bounded amount of work.
void check_units(const FlatNet& flat, NetReport& net_report, LoadReport& report);

}  // namespace takt::net
