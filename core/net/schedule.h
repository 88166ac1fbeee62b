#pragma once

#include <vector>

#include "core/net/flat_net.h"

namespace takt::net {

/// Evaluation order of all nodes, gates included: a node stands after everything it reads in the same cycle, a gate
/// before its fragment's members; where that leaves a choice, the smaller id goes first. So the order depends on ids
/// and links alone (row O1). Cycles without a delay are reported, each group once with its shortest chain of ports;
/// their nodes then stand at the end. Realtime: setup, O(n log n), no recursion.
[[nodiscard]] std::vector<int> schedule(const FlatNet& flat, LoadReport& report);

}  // namespace takt::net
