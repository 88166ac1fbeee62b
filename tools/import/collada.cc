#include "tools/import/collada.h"

#include <array>
#include <cmath>

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <assimp/Importer.hpp>

#include "tools/import/triangles.h"

namespace takt::tools {
namespace {

/// The transforms of the nodes are put into the corners, and everything but triangles is dropped.
constexpr unsigned kAssimpSteps =
    aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType | aiProcess_FindDegenerates;

std::size_t triangles_in(const aiScene& scene) {
  std::size_t count = 0;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) count += scene.mMeshes[i]->mNumFaces;
  return count;
}

/// Appends a mesh; false: a corner is no finite point.
bool append(const aiMesh& mesh, Triangles& all, Eigen::AlignedBox3d& box) {
  const int first = static_cast<int>(all.points.size());
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& v = mesh.mVertices[i];
    const Eigen::Vector3d at(v.x, v.y, v.z);
    if (!at.allFinite() || at.cwiseAbs().maxCoeff() > 1e6) return false;
    all.points.push_back(at);
    box.extend(at);
  }
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    if (face.mNumIndices != 3) continue;
    std::array<int, 3> corners{};
    for (unsigned k = 0; k < 3; ++k) corners[k] = first + static_cast<int>(face.mIndices[k]);
    all.faces.push_back(corners);
  }
  return true;
}

}  // namespace

Result<MeshFile> read_collada(const std::filesystem::path& file) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(file.string(), kAssimpSteps);
  if (scene == nullptr)
    return failure(Code::kSyntax, "", fmt::format("it cannot be read: {}", importer.GetErrorString()));
  if (const std::size_t count = triangles_in(*scene); count > kMostTriangles)
    return failure(Code::kTooLarge, "", fmt::format("{} triangles", count), fmt::format("at most {}", kMostTriangles));
  Triangles all;
  MeshFile mesh{{}, ".obj", 0, {}};
  for (unsigned i = 0; i < scene->mNumMeshes; ++i)
    if (!append(*scene->mMeshes[i], all, mesh.box))
      return failure(Code::kOutOfRange, "", "a vertex is not a finite point", "finite numbers, at most 1e6");
  mesh.triangles = all.faces.size();
  mesh.content = obj_of(all);
  return mesh;
}

}  // namespace takt::tools
