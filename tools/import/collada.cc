#include "tools/import/collada.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <assimp/Importer.hpp>

#include "tools/import/triangles.h"

namespace takt::tools {
namespace {

/// The transforms of the nodes are put into the corners, and everything but triangles is dropped.
/// Corners are shared: what tells them apart (normals, texture places, colours of corners) goes first, and a mesh of
/// kMostTriangles is then a file that our own reader takes.
constexpr unsigned kAssimpSteps = aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType |
                                  aiProcess_FindDegenerates | aiProcess_RemoveComponent |
                                  aiProcess_JoinIdenticalVertices;
constexpr int kAssimpRemoves =
    aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_TEXCOORDS | aiComponent_COLORS;

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

/// The colour that the file gives a material, empty: none. One with a texture has the colour of the texture, which is
/// left out.
std::string colour_of(const aiMaterial& material) {
  aiColor4D colour;
  if (material.GetName() == aiString(AI_DEFAULT_MATERIAL_NAME)) return {};
  if (material.GetTextureCount(aiTextureType_DIFFUSE) > 0) return {};
  if (material.Get(AI_MATKEY_COLOR_DIFFUSE, colour) != aiReturn_SUCCESS) return {};
  const auto share = [](float part) { return std::isfinite(part) ? std::clamp(part, 0.0F, 1.0F) : 0.0F; };
  return fmt::format("{:.3g} {:.3g} {:.3g} 1", share(colour.r), share(colour.g), share(colour.b));
}

/// The geometries by their colours, in the order in which these come.
std::vector<std::pair<std::string, Triangles>> by_colour(const aiScene& scene) {
  std::vector<std::pair<std::string, Triangles>> groups;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[i];
    const std::string rgba =
        mesh.mMaterialIndex < scene.mNumMaterials ? colour_of(*scene.mMaterials[mesh.mMaterialIndex]) : std::string();
    auto group = std::ranges::find(groups, rgba, &std::pair<std::string, Triangles>::first);
    if (group == groups.end()) group = groups.insert(groups.end(), {rgba, {}});
    Eigen::AlignedBox3d ignored;
    (void)append(mesh, group->second, ignored);
  }
  std::erase_if(groups, [](const auto& group) { return group.second.faces.empty(); });
  return groups;
}

}  // namespace

Result<MeshFile> read_collada(const std::filesystem::path& file) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, kAssimpRemoves);
  const aiScene* scene = importer.ReadFile(file.string(), kAssimpSteps);
  if (scene == nullptr)
    return failure(Code::kSyntax, "", fmt::format("it cannot be read: {}", importer.GetErrorString()));
  if (const std::size_t count = triangles_in(*scene); count > kMostTriangles)
    return failure(Code::kTooLarge, "", fmt::format("{} triangles", count),
                   fmt::format("Keep it to at most {}", kMostTriangles));
  Triangles all;
  MeshFile mesh{{}, ".obj", 0, {}};
  for (unsigned i = 0; i < scene->mNumMeshes; ++i)
    if (!append(*scene->mMeshes[i], all, mesh.box))
      return failure(Code::kOutOfRange, "", "a vertex is not a finite point", "Give finite numbers of at most 1e6");
  mesh.triangles = all.faces.size();
  mesh.content = obj_of(all);
  const auto groups = by_colour(*scene);
  if (groups.size() == 1 && groups.front().first.empty()) return mesh;
  for (const auto& [rgba, triangles] : groups) mesh.colours.push_back({obj_of(triangles), rgba});
  return mesh;
}

}  // namespace takt::tools
