#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "core/base/diagnostics.h"

namespace takt::collision {

/// All corners of the triangles of a mesh file: STL (binary or text) or OBJ, as the file has them, without scale.
/// @return the points, or a diagnostic with the file: not readable, neither of the two, no triangle, truncated, a
/// coordinate that is not finite. Realtime: setup.
[[nodiscard]] Result<std::vector<Eigen::Vector3d>> read_mesh_points(const std::filesystem::path& file);

}  // namespace takt::collision
