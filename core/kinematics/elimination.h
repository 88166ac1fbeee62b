#pragma once

#include <array>
#include <vector>

#include <Eigen/Geometry>

#include "core/kinematics/lines.h"

namespace takt::kinematics {

/// Angles of six revolute joints with *any* axes that make the motion T = turn 1 ... turn 6: at most sixteen real ones
/// exist. The six equations are multilinear in the joints' sines and cosines; two joints are eliminated linearly, the
/// rest is an eigenvalue problem of size 24 whose eigenvalues are the tangents of half an angle.
/// @param lines  the axes at zero, in the frame of T   @param first  0..5: which joint the loop is opened at: it
/// changes
///        rounding, and which special geometries are degenerate, but not the solutions
/// @param[out] found  candidates are added, good to about 1e-6: whoever uses them polishes and checks
/// Source: Raghavan, Roth 1993 (equations); Manocha, Canny 1994 (eigenvalues); the coefficients are found here by
/// evaluation at 27 points instead of by formulas in DH parameters. Realtime: setup.
void eliminate(const std::array<Line, 6>& lines, const Eigen::Isometry3d& T, int first,
               std::vector<std::array<double, 6>>& found);

}  // namespace takt::kinematics
