#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/collision/contact_rules.h"
#include "core/expression/cell.h"
#include "core/expression/sensor.h"

/// The solids of a cell where the program believes them to be. Realtime: setup.
namespace takt::expression {

/// How far apart the fingers of grippers stand, m, by device.
using FingerWidths = std::map<std::string, double, std::less<>>;

/// The cell as it is believed to be. The cell has shapes.
/// @param q       of each arm, rad or m; those that are not there stand where they start
/// @param widths  of grippers; those that are not there stand as at the start
[[nodiscard]] collision::CellState believed_situation(const Cell& cell, const Places& q, const FingerWidths& widths);

/// Puts an arm into a state. @param q  rad or m; an arm that the shapes do not have is not put
void set_joints(const collision::CellShapes& shapes, const std::string& arm, const kinematics::JointVector& q,
                collision::State& state);

/// What grippers say of their fingers; those that have not said anything are not there.
[[nodiscard]] FingerWidths measured_widths(const Cell& cell);

/// The smallest distance of two sides, m; 0 where they touch. Each is a list of devices, objects and bodies
/// ("arm/link_3"); an arm or base is meant with all that it carries. Objects and fingers count where they are believed
/// to be when the net is loaded. Null while an arm does not say where it is.
[[nodiscard]] RealSensor smallest_distance(const Cell& cell, const std::vector<std::string>& side_a,
                                           const std::vector<std::string>& side_b);

}  // namespace takt::expression
