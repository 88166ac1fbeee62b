#pragma once

#include "core/net/flat_net.h"
#include "core/net/net_report.h"

namespace takt::net {

/// One driver per device (row O4). Several primitives may drive one device, and several fragments meet at one Merge, if
/// no two of them are ever active together; that is proven here from the activations of their fragments. A device that
/// is shared without a proof is an error; a Merge without one gets a note, and a conflict while running is a failure.
/// Writes `resources` and `exclusions` of the report. Realtime: setup; the work is bounded.
void check_exclusions(const FlatNet& flat, NetReport& net_report, LoadReport& report);

}  // namespace takt::net
