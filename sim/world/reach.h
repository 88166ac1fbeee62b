#pragma once

#include <utility>
#include <vector>

struct mjModel_;

namespace takt::sim {

/// Pairs of bodies that cannot touch in any posture within the joints' ranges, and so need not be searched for
/// contacts. A pair is listed only if that is proven: shapes are covered with balls, and what a joint can do to a ball
/// is bounded by its distance from the axis; where the proof is not done within a fixed effort, the pair stays. Bodies
/// that move freely, and what hangs on them, are in no pair. Idea: docs/simulation.md, "What is not searched".
/// @return numbers of bodies, the smaller first, each pair once
/// Realtime: setup.
[[nodiscard]] std::vector<std::pair<int, int>> never_meet(const mjModel_& model);

/// Bodies whose shapes meet nothing at all once these pairs are left out. Realtime: setup.
[[nodiscard]] std::vector<int> meet_nothing(const mjModel_& model, const std::vector<std::pair<int, int>>& never);

}  // namespace takt::sim
