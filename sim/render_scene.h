#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "sim/render_shapes.h"

struct mjvScene_;
struct mjModel_;

namespace takt::sim {

/// A corner as the graphics driver gets it, in world coordinates.
struct SceneVertex {
  std::array<float, 3> position;
  std::array<float, 3> normal;
  std::array<std::uint8_t, 4> colour;    ///< sRGB and opacity
  std::array<std::uint8_t, 4> material;  ///< specular, shininess, emission in 1/255, unused
};

/// A run of triangles of one geom in the vertex list.
struct SceneGeom {
  std::uint32_t first_vertex = 0;
  const Shape* shape = nullptr;
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();
  bool casts_shadow = false;
  bool transparent = false;
  bool is_floor = false;
};

/// All geoms of a mjvScene as one list of triangles in world coordinates: the scenes are small, so moving the corners
/// on the CPU is far cheaper than a draw call per geom.
struct SceneTriangles {
  std::vector<SceneVertex> vertices;
  std::vector<SceneGeom> geoms;

  /// Replaces the content by the geoms of `scene`.
  void fill(const mjModel_* model, const mjvScene_& scene, const ShapeLibrary& shapes);
};

/// Appends the triangles of `geom` to `indices`.
void append_indices(const SceneGeom& geom, std::vector<std::uint32_t>& indices);

/// The lights of a scene as the surface shader wants them.
struct SceneLights {
  static constexpr int kMost = 8;
  int count = 0;
  int shadow_light = -1;    ///< index of the one that casts the shadow; -1: none
  bool all_distant = true;  ///< no light stands in the room
  Eigen::Vector3f ambient = Eigen::Vector3f::Zero();
  std::array<Eigen::Vector3f, kMost> at, axis, diffuse, specular;
  std::array<Eigen::Vector4f, kMost> fading;
  std::string code;  ///< GLSL statements that add up the lights; the key of the program that can draw them

  void fill(const mjvScene_& scene);
};

/// World to clip coordinates of the light's view for the shadow map.
/// @param centre, radius  m, the sphere that a distant light covers
[[nodiscard]] Eigen::Matrix4f shadow_view(const mjvScene_& scene, const Eigen::Vector3f& centre, float radius,
                                          float spot_scale);

/// World to clip coordinates of the scene's camera; y points down, so that rows come out from the top.
[[nodiscard]] Eigen::Matrix4f camera_view(const mjvScene_& scene, float aspect);

}  // namespace takt::sim
