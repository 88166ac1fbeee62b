#pragma once

#include <optional>
#include <string>

#include "core/expression/cell.h"

/// What coupling does to what the application believes: which tools hang on which arm. The same in a rehearsal as in a
/// run. Realtime: setup.
namespace takt::expression {

/// What hangs on a changer; empty: nothing.
[[nodiscard]] std::string coupled_side(const Cell& cell, std::string_view changer);
/// The tool side of this name, or the one that a tool of this name is mounted on; nothing: there is none.
[[nodiscard]] std::optional<std::string> side_named(const Cell& cell, std::string_view name);
/// The tool side that is believed to be where the changer could couple it. @param X_WC  its coupling face, m
[[nodiscard]] std::optional<std::string> side_at(const Cell& cell, const MountedChanger& changer,
                                                 const Eigen::Isometry3d& X_WC);

/// The changer has coupled a tool side: it rides on the flange with all that is mounted on it, its tools are tools of
/// the arm. @return diagnostics: there is no such frame
[[nodiscard]] Diagnostics couple(Cell& cell, const std::string& changer, const std::string& side);
/// The changer has let go of what hung on it, which stays where it is.
/// @param onto  frame that it depends on from now on   @return diagnostics: there is no such frame
[[nodiscard]] Diagnostics uncouple(Cell& cell, const std::string& changer, const Eigen::Isometry3d& X_WS,
                                   const std::string& onto);
/// The belief was put back: tools hang where Belief::held says.
void hang_coupled_tools(Cell& cell);
/// The changer has lost it: nobody knows where it is.
void lose_coupled(Cell& cell, const std::string& changer);

}  // namespace takt::expression
