#pragma once

#include <functional>
#include <set>
#include <string>
#include <string_view>

#include "core/expression/cell.h"

namespace takt::expression {

/// Sets the frames of a cell that move with arms, on their flanges and links, to where these are: what a program plans
/// with while the arm or base below is at rest. @param q_of  joint positions of an arm by name, rad or m; size 0: not
/// known. Realtime: setup.
void update_flange_frames(Cell& cell, const std::function<kinematics::JointVector(const std::string&)>& q_of);

/// At the set points that were sent last, or where the arms start; and frames that channels move where those say.
void update_flange_frames(Cell& cell);

/// The cell as it is when arms are elsewhere: what moves with them is there too; on an arm whose position has
/// size 0 it is unknown. Realtime: setup.
[[nodiscard]] Cell cell_at(const Cell& cell, const Places& places);

/// The arms and bases on which it depends where frame `of` is in frame `in`. Empty if one of the two is not there.
[[nodiscard]] std::set<std::string> movers_between(const world::FrameGraph& frames, std::string_view of,
                                                   std::string_view in);

/// Where frame `of` is in frame `in` changes while nets run. False if one of them is not there.
[[nodiscard]] bool moves(const world::FrameGraph& frames, std::string_view of, std::string_view in);

}  // namespace takt::expression
