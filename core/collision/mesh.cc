#include "core/collision/mesh.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace takt::collision {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// A binary STL: 80 bytes of header, a count, 50 bytes a triangle (normal, three corners, two bytes).
constexpr std::size_t kStlHeader = 80;
constexpr std::size_t kStlTriangle = 50;

bool is_binary_stl(std::string_view text) {
  if (text.size() < kStlHeader + 4) return false;
  std::uint32_t count = 0;
  std::memcpy(&count, text.data() + kStlHeader, sizeof count);
  return text.size() == kStlHeader + 4 + kStlTriangle * static_cast<std::size_t>(count);
}

Points binary_stl(std::string_view text) {
  Points points;
  for (std::size_t at = kStlHeader + 4; at + kStlTriangle <= text.size(); at += kStlTriangle) {
    float corners[9];
    std::memcpy(corners, text.data() + at + 12, sizeof corners);
    for (int i = 0; i < 3; ++i) points.emplace_back(corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]);
  }
  return points;
}

/// Lines "vertex x y z" of a text STL, "v x y z" of an OBJ.
Points text_points(const std::string& text, std::string_view word) {
  Points points;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string first;
    Eigen::Vector3d point;
    if (words >> first && first == word && words >> point.x() >> point.y() >> point.z()) points.push_back(point);
  }
  return points;
}

}  // namespace

Result<Points> read_mesh_points(const std::filesystem::path& file) {
  const auto wrong = [&](Code code, const std::string& what, const std::string& allowed) {
    return failure(code, "", fmt::format("mesh '{}' {}", file.string(), what), allowed);
  };
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return wrong(Code::kFileNotReadable, "cannot be read", "a readable file");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  std::string kind = file.extension().string();
  for (char& letter : kind) letter = static_cast<char>(letter >= 'A' && letter <= 'Z' ? letter - 'A' + 'a' : letter);
  Points points;
  if (kind == ".stl") {
    points = is_binary_stl(text) ? binary_stl(text) : text_points(text, "vertex");
  } else if (kind == ".obj") {
    points = text_points(text, "v");
  } else {
    return wrong(Code::kUnsupported, "is of a kind that is not read", ".stl or .obj");
  }
  if (points.size() < 3) return wrong(Code::kInvalidValue, "has no triangle", "a whole STL or OBJ file");
  for (const Eigen::Vector3d& point : points) {
    if (!point.allFinite()) return wrong(Code::kInvalidValue, "has a coordinate that is not finite", "finite numbers");
  }
  return points;
}

}  // namespace takt::collision
