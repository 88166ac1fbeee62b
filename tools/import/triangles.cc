#include "tools/import/triangles.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <locale>
#include <map>
#include <sstream>

#include <fmt/format.h>

namespace takt::tools {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Face = std::array<int, 3>;

/// Collects corners; equal ones share a point.
class Builder {
 public:
  int point(const Vector3d& at) {
    const auto [found, is_new] = known_.try_emplace({at.x(), at.y(), at.z()}, static_cast<int>(mesh_.points.size()));
    if (is_new) mesh_.points.push_back(at);
    return found->second;
  }
  /// Triangles without area enclose nothing.
  void face(const Face& face) {
    if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) mesh_.faces.push_back(face);
  }
  [[nodiscard]] Triangles take() { return std::move(mesh_); }

 private:
  Triangles mesh_;
  std::map<std::array<double, 3>, int> known_;
};

Triangles of_stl(const std::string& content) {
  constexpr std::size_t kStlHeader = 84, kStlTriangle = 50, kStlNormal = 12;
  Builder builder;
  for (std::size_t at = kStlHeader; at + kStlTriangle <= content.size(); at += kStlTriangle) {
    std::array<float, 9> corners;
    std::memcpy(corners.data(), content.data() + at + kStlNormal, sizeof corners);
    Face face;
    for (std::size_t k = 0; k < 3; ++k)
      face[k] = builder.point(Vector3d(corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]));
    builder.face(face);
  }
  return builder.take();
}

/// The number of a corner in a word of a face: "7", "7/1/2", "-1" (the newest). -1: there is none.
int corner_of(const std::string& word, std::size_t count) {
  std::istringstream in(word);
  in.imbue(std::locale::classic());
  long long number = 0;
  if (!(in >> number) || number == 0) return -1;
  const long long index = number > 0 ? number - 1 : static_cast<long long>(count) + number;
  return index >= 0 && index < static_cast<long long>(count) ? static_cast<int>(index) : -1;
}

Result<Triangles> of_obj(const std::string& content) {
  Builder builder;
  std::vector<int> points;
  std::istringstream lines(content);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream row(line);
    row.imbue(std::locale::classic());
    std::string word;
    row >> word;
    if (word == "v") {
      Vector3d at;
      row >> at.x() >> at.y() >> at.z();
      points.push_back(builder.point(at));
    } else if (word == "f") {
      std::vector<int> corners;
      while (row >> word) {
        const int corner = corner_of(word, points.size());
        if (corner < 0)
          return failure(Code::kOutOfRange, fmt::format("line {}", number),
                         fmt::format("there is no corner '{}'", word), fmt::format("Choose 1 to {}", points.size()));
        corners.push_back(points[static_cast<std::size_t>(corner)]);
      }
      for (std::size_t k = 2; k < corners.size(); ++k) builder.face({corners[0], corners[k - 1], corners[k]});
    }
  }
  return builder.take();
}

}  // namespace

bool Triangles::closed() const {
  std::map<std::pair<int, int>, int> edges;  // times forwards less times backwards, and whether it is met once
  for (const Face& face : faces)
    for (std::size_t k = 0; k < 3; ++k)
      if (++edges[{face[k], face[(k + 1) % 3]}] > 1) return false;
  return !faces.empty() && std::ranges::all_of(edges, [&](const auto& one) {
    return edges.contains({one.first.second, one.first.first});
  });
}

Result<Triangles> triangles_of(const MeshFile& mesh) {
  return mesh.extension == ".stl" ? Result<Triangles>(of_stl(mesh.content)) : of_obj(mesh.content);
}

std::string obj_of(const Triangles& mesh, double scale) {
  std::string text;
  for (const Vector3d& p : mesh.points)
    text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", scale * p.x(), scale * p.y(), scale * p.z());
  for (const Face& face : mesh.faces) text += fmt::format("f {} {} {}\n", face[0] + 1, face[1] + 1, face[2] + 1);
  return text;
}

SolidFigures solid_figures(const Triangles& mesh) {
  SolidFigures figures;
  Vector3d moment = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();  // integral of p p^T
  for (const Face& face : mesh.faces) {
    const Vector3d &a = mesh.points[static_cast<std::size_t>(face[0])],
                   &b = mesh.points[static_cast<std::size_t>(face[1])],
                   &c = mesh.points[static_cast<std::size_t>(face[2])];
    const double volume = a.dot(b.cross(c)) / 6.0;
    const Vector3d sum = a + b + c;
    figures.volume += volume;
    moment += 0.25 * volume * sum;
    second += 0.05 * volume * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  }
  if (std::abs(figures.volume) < std::numeric_limits<double>::min()) return figures;
  figures.centre = moment / figures.volume;
  const Matrix3d central = second - figures.volume * figures.centre * figures.centre.transpose();
  figures.inertia = central.trace() * Matrix3d::Identity() - central;
  return figures;
}

}  // namespace takt::tools
