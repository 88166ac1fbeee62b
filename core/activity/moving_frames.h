#pragma once

#include <functional>
#include <string>

#include "core/command/cell.h"

namespace takt::activity {

/// Tells the frames of a cell that ride on the flanges of arms where these are: what a program plans with while the
/// arm or base below stands. @param q_of  joint positions of an arm by name, rad or m; size 0: not known. Realtime:
/// setup.
void see_flanges(command::Cell& cell, const std::function<kinematics::JointVector(const std::string&)>& q_of);

/// At the set points that were sent last, or where the arms start.
void see_flanges(command::Cell& cell);

}  // namespace takt::activity
