#pragma once

#include <string>

#include "core/expression/cell.h"

/// What closing fingers do to a part (docs/world.md, "Objects"). Realtime: setup.
namespace takt::operations {

/// A part that does not lie in the middle between the two fingers of a gripper is pushed by the one that touches it
/// first, along the way of the fingers, until the other touches it too. How it turns against them is not considered.
/// @param X_FO  the part in the flange of the arm that carries the gripper before the fingers close, m
/// @return the same when they have closed; X_FO where the part is not between them, or shapes are not known
[[nodiscard]] Eigen::Isometry3d pushed_by_fingers(const expression::Cell& cell, const std::string& gripper,
                                                  const std::string& object, const Eigen::Isometry3d& X_FO);

}  // namespace takt::operations
