#pragma once

#include <filesystem>

#include "core/base/diagnostics.h"
#include "tools/import/mesh_files.h"

namespace takt::tools {

/// A COLLADA file (.dae) as a mesh: all its geometries with the transforms of their nodes, in m by the file's unit, in
/// the axes of the file, whatever it says of "up", as ROS shows it. Of materials their diffuse colours are read; lines,
/// points, textures and transparency are left out.
/// @return diagnostics: it cannot be read, it has no triangle, it has more than kMostTriangles.
[[nodiscard]] Result<MeshFile> read_collada(const std::filesystem::path& file);

}  // namespace takt::tools
