#include "tools/import/convex_parts.h"

#include <dlfcn.h>

#include <cmath>
#include <cstdint>
#include <filesystem>

#include <fmt/format.h>

#include "core/collision/hull.h"

namespace takt::tools {
namespace {

namespace fs = std::filesystem;

// -- The library's interface: its functions and what they are given, in C ---------------------------------------------

struct CoacdMesh {
  double* points;  ///< x, y, z
  std::uint64_t point_count;
  int* triangles;
  std::uint64_t triangle_count;
};
struct CoacdMeshes {
  CoacdMesh* meshes;
  std::uint64_t count;
};
using CoacdRun = CoacdMeshes(const CoacdMesh*, double threshold, int most_parts, int closing, int closing_resolution,
                             int samples, int nodes, int iterations, int depth, bool pca, bool merge, bool decimate,
                             int most_points, bool extrude, double extrude_margin, int shape, unsigned int seed,
                             bool threshold_in_unit);
using CoacdFree = void(CoacdMeshes);
using CoacdLogLevel = void(const char*);

/// The shared library, opened with symbols of its own: it brings a copy of the C++ library that is not to be mixed with
/// ours.
class Coacd {
 public:
  static const Coacd& get() {
    static const Coacd library;
    return library;
  }
  [[nodiscard]] bool usable() const { return run != nullptr && free != nullptr; }

  CoacdRun* run = nullptr;
  CoacdFree* free = nullptr;

 private:
  Coacd() {
    void* handle = nullptr;
    for (const fs::path& file : places())
      if (handle == nullptr) handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) return;
    run = reinterpret_cast<CoacdRun*>(dlsym(handle, "CoACD_run"));
    free = reinterpret_cast<CoacdFree*>(dlsym(handle, "CoACD_freeMeshArray"));
    if (auto* quiet = reinterpret_cast<CoacdLogLevel*>(dlsym(handle, "CoACD_setLogLevel"))) quiet("off");
  }
  /// In the tree that built this program; in an install.
  static std::vector<fs::path> places() {
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
    return {TAKT_COACD, program.parent_path() / TAKT_INSTALL_LIBDIR / "takt" / "coacd" / "lib_coacd.so"};
  }
};

/// Copies what the library owns.
Triangles copy(const CoacdMesh& mesh) {
  Triangles part;
  for (std::uint64_t i = 0; i < mesh.point_count; ++i) {
    const double* at = mesh.points + 3 * i;
    part.points.emplace_back(at[0], at[1], at[2]);
  }
  for (std::uint64_t i = 0; i < mesh.triangle_count; ++i) {
    const int* corners = mesh.triangles + 3 * i;
    part.faces.push_back({corners[0], corners[1], corners[2]});
  }
  return part;
}

Result<Triangles> hull_of(const Triangles& mesh) {
  auto hull = collision::convex_hull(mesh.points);
  if (!hull) return std::unexpected(hull.error());
  Triangles part{std::move(hull->corners), {}};
  for (std::size_t i = 0; i + 2 < hull->triangles.size(); i += 3)
    part.faces.push_back({hull->triangles[i], hull->triangles[i + 1], hull->triangles[i + 2]});
  return part;
}

}  // namespace

Result<double> hull_volume(const Triangles& mesh) {
  const auto hull = hull_of(mesh);
  if (!hull) return std::unexpected(hull.error());
  return solid_figures(*hull).volume;
}

Result<std::vector<Triangles>> convex_parts(const Triangles& mesh, const SplitOptions& options) {
  constexpr double kConvex = 0.999;
  const auto hull = hull_of(mesh);
  if (!hull) return std::unexpected(hull.error());
  const bool closed = mesh.closed();
  if (closed && solid_figures(mesh).volume >= kConvex * solid_figures(*hull).volume) return std::vector{*hull};
  const Coacd& coacd = Coacd::get();
  if (!coacd.usable())
    return failure(Code::kNotFound, "", "the library that splits meshes is not there", "Build with the network up");
  std::vector<double> points;
  for (const Eigen::Vector3d& p : mesh.points) points.insert(points.end(), {p.x(), p.y(), p.z()});
  std::vector<int> corners;
  for (const auto& face : mesh.faces) corners.insert(corners.end(), face.begin(), face.end());
  const CoacdMesh input{points.data(), mesh.points.size(), corners.data(), mesh.faces.size()};
  constexpr int kCloseFromVoxels = 1, kAsItIs = 2, kHulls = 0;
  const CoacdMeshes found =
      coacd.run(&input, options.concavity, options.most_parts, closed ? kAsItIs : kCloseFromVoxels, 50, 2000, 20, 150,
                3, false, true, false, 256, false, 0.01, kHulls, 1, false);
  std::vector<Triangles> parts;
  for (std::uint64_t i = 0; i < found.count; ++i)
    if (auto part = hull_of(copy(found.meshes[i]))) parts.push_back(std::move(*part));  // not one without a volume
  coacd.free(found);
  if (parts.empty())
    return failure(Code::kInvalidValue, "", "no convex part was found", "Close the surface of the mesh");
  return parts;
}

}  // namespace takt::tools
