#pragma once

#include <string>

#include "sim/model/world_description.h"

struct mjSpec_;

namespace takt::sim {

/// Fills an empty MuJoCo specification from a description that has passed check(). Every link of a URDF becomes a body
/// of its own, also behind fixed joints and at a fixed base, so that no mass is lost (docs/simulation.md, "The
/// model"). Names: bodies "ROBOT/LINK" and "OBJECT", joints "ROBOT/JOINT", materials "ROBOT/MATERIAL", sensors
/// "DEVICE/force" and "DEVICE/torque". Geometry groups: 1 objects, 2 visuals, 3 collisions. Realtime: setup.
/// @param visuals  false leaves out what only pictures need of the robots; bodies and their numbers stay the same
void build_spec(const WorldDescription& description, bool visuals, mjSpec_& spec);

}  // namespace takt::sim
