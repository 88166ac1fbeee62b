#include "tools/import/mesh_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <locale>
#include <sstream>

#include <fmt/format.h>

#include "core/base/json.h"
#include "tools/import/collada.h"

namespace takt::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHeader = 84;    // of a binary STL: 80 bytes of anything, then the number of triangles
constexpr std::size_t kTriangle = 50;  // normal, three corners, two bytes
/// As text, a triangle takes about 270 bytes as STL and 100 as OBJ.
constexpr std::size_t kMostBytes = 400 * kMostTriangles;

using Corner = std::array<float, 3>;

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Numbers with a decimal point, whatever the locale of the program.
std::istringstream numbers_of(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  return in;
}

/// Corners that are no numbers break every reader after us.
bool extend(Eigen::AlignedBox3d& box, const Corner& corner) {
  const Eigen::Vector3d at(corner[0], corner[1], corner[2]);
  if (!at.allFinite() || at.cwiseAbs().maxCoeff() > 1e6) return false;
  box.extend(at);
  return true;
}

Result<MeshFile> binary_stl(std::string content) {
  MeshFile mesh{std::move(content), ".stl", 0, {}};
  std::uint32_t count = 0;
  std::memcpy(&count, mesh.content.data() + 80, sizeof count);
  mesh.triangles = count;
  for (std::size_t t = 0; t < mesh.triangles; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      Corner corner;
      std::memcpy(corner.data(), mesh.content.data() + kHeader + t * kTriangle + 12 + 12 * k, sizeof corner);
      if (!extend(mesh.box, corner))
        return failure(Code::kOutOfRange, "", "a vertex is not a finite point", "Give finite numbers of at most 1e6");
    }
  }
  return mesh;
}

std::string to_binary(const std::vector<Corner>& corners) {
  std::string out(80, ' ');
  const auto append = [&out](const auto& value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  append(static_cast<std::uint32_t>(corners.size() / 3));
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    append(Corner{0, 0, 0});  // readers compute the normal
    for (std::size_t k = 0; k < 3; ++k) append(corners[i + k]);
    append(std::uint16_t{0});
  }
  return out;
}

Result<MeshFile> text_stl(const std::string& content) {
  std::istringstream in = numbers_of(content);
  std::vector<Corner> corners;
  for (std::string word; in >> word;) {
    if (word != "vertex") continue;
    Corner corner;
    if (!(in >> corner[0] >> corner[1] >> corner[2]))
      return failure(Code::kSyntax, "", "a vertex without three numbers");
    corners.push_back(corner);
  }
  if (corners.size() % 3 != 0) return failure(Code::kSyntax, "", "a facet without three corners");
  if (corners.size() / 3 > kMostTriangles) return too_many_triangles(corners.size() / 3);
  return binary_stl(to_binary(corners));
}

Result<MeshFile> read_stl(std::string content) {
  std::uint32_t count = 0;
  if (content.size() >= kHeader) std::memcpy(&count, content.data() + 80, sizeof count);
  const bool binary = content.size() >= kHeader && content.size() == kHeader + std::size_t{count} * kTriangle;
  if (binary)
    return count > kMostTriangles ? Result<MeshFile>(too_many_triangles(count)) : binary_stl(std::move(content));
  if (content.starts_with("solid")) return text_stl(content);
  return failure(Code::kSyntax, "", "it is neither a binary STL of the size that it claims nor a text STL");
}

Result<MeshFile> read_obj(std::string content) {
  MeshFile mesh{{}, ".obj", 0, {}};
  std::istringstream in(content);
  for (std::string line; std::getline(in, line);) {
    std::istringstream row = numbers_of(line);
    std::string word;
    row >> word;
    if (word == "v") {
      Corner corner;
      const bool whole = static_cast<bool>(row >> corner[0] >> corner[1] >> corner[2]);
      if (!whole || !extend(mesh.box, corner))
        return failure(Code::kOutOfRange, "", "a vertex is not a finite point", "Give finite numbers of at most 1e6");
    } else if (word == "f") {
      std::size_t corners = 0;
      while (row >> word) ++corners;
      mesh.triangles += corners > 2 ? corners - 2 : 0;
    }
  }
  // Looks come from the URDF: a library of materials would be one more file to find.
  for (std::size_t at = 0; (at = content.find("mtllib", at)) != std::string::npos;) content.replace(at, 6, "#     ");
  mesh.content = std::move(content);
  if (mesh.triangles > kMostTriangles) return too_many_triangles(mesh.triangles);
  return mesh;
}

}  // namespace

std::unexpected<Diagnostics> too_many_triangles(std::size_t triangles) {
  return failure(Code::kTooLarge, "", fmt::format("{} triangles", triangles),
                 fmt::format("Keep it to at most {}", kMostTriangles));
}

MeshPaths::MeshPaths(const fs::path& urdf, std::vector<fs::path> packages) : roots_(std::move(packages)) {
  std::error_code error;
  folder_ = fs::absolute(urdf, error).lexically_normal().parent_path();
  for (fs::path above = folder_; above != above.root_path(); above = above.parent_path()) roots_.push_back(above);
}

std::optional<fs::path> MeshPaths::find(const std::string& name) const {
  std::error_code error;
  const auto file = [&](const fs::path& path) { return fs::is_regular_file(path, error); };
  if (name.starts_with("file://")) {
    const fs::path path = name.substr(7);
    return file(path) ? std::optional(path) : std::nullopt;
  }
  const auto scheme = name.find("://");
  if (scheme == std::string::npos) {
    const fs::path path = folder_ / name;
    return file(path) ? std::optional(path) : std::nullopt;
  }
  const std::string rest = name.substr(scheme + 3);
  const auto slash = rest.find('/');
  if (slash == std::string::npos) return std::nullopt;
  const std::string package = rest.substr(0, slash), inside = rest.substr(slash + 1);
  for (const fs::path& root : roots_) {
    if (file(root / package / inside)) return root / package / inside;
    if (root.filename() == package && file(root / inside)) return root / inside;
  }
  // A package that was copied under another name still has its inner folders.
  for (const fs::path& root : roots_) {
    if (file(root / inside)) return root / inside;
  }
  return std::nullopt;
}

Result<MeshFile> read_mesh(const fs::path& file) {
  const std::string extension = lower(file.extension().string());
  if (extension != ".stl" && extension != ".obj" && extension != ".dae") {
    return failure(Code::kUnsupported, "",
                   fmt::format("{} is not read", extension.empty() ? "a file without extension" : extension),
                   "Use .stl, .obj or .dae");
  }
  std::error_code error;
  if (const auto bytes = fs::file_size(file, error); !error && bytes > kMostBytes)
    return too_many_triangles(bytes / 400);
  if (extension == ".dae") {
    auto mesh = read_collada(file);
    if (mesh && mesh->triangles == 0) return failure(Code::kMissing, "", "it has no triangle");
    return mesh;
  }
  auto content = read_file(file, kMostBytes);
  if (!content) return std::unexpected(content.error());
  auto mesh = extension == ".stl" ? read_stl(std::move(*content)) : read_obj(std::move(*content));
  if (mesh && mesh->triangles == 0) return failure(Code::kMissing, "", "it has no triangle");
  return mesh;
}

Eigen::AlignedBox3d mesh_box(const std::string& content, const std::string& name) {
  const auto mesh = name.ends_with(".stl") ? read_stl(content) : read_obj(content);
  return mesh ? mesh->box : Eigen::AlignedBox3d();
}

}  // namespace takt::tools
