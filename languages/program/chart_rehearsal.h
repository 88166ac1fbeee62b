#pragma once

#include <vector>

#include "core/program/tree/node.h"
#include "languages/program/chart_calls.h"

namespace takt::languages {

/// Runs charts on nominal values: what they invoke is rehearsed in the order in which they invoke it, and takes as long
/// as it is planned; then what was never invoked, from where the charts begin, with warnings in place of errors. What
/// two of them drive at the same time is a conflict.
void rehearse_charts(const std::vector<ProgramChart>& charts, const program::Node& node,
                     operations::Rehearsal& rehearsal, Diagnostics& diagnostics);

}  // namespace takt::languages
