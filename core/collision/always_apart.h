#pragma once

#include "core/collision/scene.h"

namespace takt::collision {

/// Whether two bodies of one machine never come nearer to each other than a distance, whatever their joints do within
/// their ranges. Tried where one or two revolute joints are between them: of two the outer body is taken as what it
/// sweeps in a whole turn about the one next to it. Then the range of the other is halved: at the middle of each part
/// the two have to be further apart than any point can travel from there.
/// @param lower, upper  of all joints, rad or m   @param wanted  m, > 0
/// @return true: proven; false: they come nearer, or it is too much work. Realtime: setup, deterministic.
[[nodiscard]] bool always_apart(const Scene& scene, int a, int b, std::span<const double> lower,
                                std::span<const double> upper, double wanted);

}  // namespace takt::collision
