#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "core/expression/cell.h"

namespace takt::activity {

/// Tells the frames of a cell that ride on the flanges of arms where these are: what a program plans with while the
/// arm or base below stands. @param q_of  joint positions of an arm by name, rad or m; size 0: not known. Realtime:
/// setup.
void see_flanges(command::Cell& cell, const std::function<kinematics::JointVector(const std::string&)>& q_of);

/// At the set points that were sent last, or where the arms start.
void see_flanges(command::Cell& cell);

/// The cell as it is when arms stand elsewhere: what rides on their flanges is there too; on that of an arm whose place
/// has size 0 nobody knows where it is. Realtime: setup.
[[nodiscard]] command::Cell cell_at(const command::Cell& cell, const command::Places& places);

/// Where frame `of` is in frame `in` changes while nets run. False if one of them is not there.
[[nodiscard]] bool moves(const world::FrameGraph& frames, std::string_view of, std::string_view in);

}  // namespace takt::activity
