#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/diagnostics.h"

namespace takt::tools {

/// More triangles than this make neither a better picture nor a better contact, only waiting: such a mesh is replaced.
inline constexpr std::size_t kMostTriangles = 100'000;

/// Where meshes of a foreign URDF may lie.
class MeshPaths {
 public:
  /// @param urdf  the file   @param packages  folders that hold packages, or are packages, beside those around the file
  MeshPaths(const std::filesystem::path& urdf, std::vector<std::filesystem::path> packages);
  /// The file that a URDF means by "package://NAME/PATH", "model://NAME/PATH", "file:///PATH" or a relative path;
  /// nothing if there is none. Packages are looked for in the given folders, then in the folders above the URDF,
  /// nearest first.
  [[nodiscard]] std::optional<std::filesystem::path> find(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> roots_;
};

/// A mesh file as MuJoCo reads it (binary STL or OBJ).
struct MeshFile {
  std::string content;
  std::string extension;  ///< ".stl" or ".obj"
  std::size_t triangles = 0;
  Eigen::AlignedBox3d box;  ///< in the unit of the file

  /// What of it has one colour, in the same form.
  struct Coloured {
    std::string content;
    std::string rgba;  ///< as a URDF writes it, 0 to 1; empty: the file says none
  };
  std::vector<Coloured> colours = {};  ///< of a file that says colours, one each; else empty
};

/// Reads STL (text becomes binary), OBJ or COLLADA (becomes OBJ, read_collada). @return what is wrong otherwise:
/// another format, broken, no triangle, more than kMostTriangles (the file is not read then).
[[nodiscard]] Result<MeshFile> read_mesh(const std::filesystem::path& file);

/// The diagnostic of a mesh that has more than kMostTriangles.
[[nodiscard]] std::unexpected<Diagnostics> too_many_triangles(std::size_t triangles);

/// The box around the content of a mesh that read_mesh has made, named with its extension.
[[nodiscard]] Eigen::AlignedBox3d mesh_box(const std::string& content, const std::string& name);

}  // namespace takt::tools
