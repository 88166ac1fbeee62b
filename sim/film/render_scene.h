#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "sim/film/render_shapes.h"

struct mjvScene_;
struct mjModel_;
struct mjData_;

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
  bool on_top = false;  ///< drawn over whatever would hide it
  int model_geom = -1;  ///< its number in the model; negative: it is none of it

  /// All that its triangles follow from: geoms with equal looks are drawn as the same pixels.
  using Look = std::array<std::uint32_t, 21>;
  Look look{};
  Eigen::AlignedBox3f box{};  ///< around its corners, in world
};

/// All geoms of a mjvScene as one list of triangles in world coordinates: the scenes are small, so moving the corners
/// on the CPU is far cheaper than a draw call per geom.
struct SceneTriangles {
  std::vector<SceneVertex> vertices;
  std::vector<SceneGeom> geoms;

  /// Replaces the content by the geoms of `scene`, which was made from `data`.
  void fill(const mjModel_* model, const mjData_* data, const mjvScene_& scene, const ShapeLibrary& shapes);
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

/// The view of the light that casts the shadow.
struct ShadowView {
  Eigen::Matrix4f clip_from_world = Eigen::Matrix4f::Identity();
  float width = 0;  ///< m that the map covers; for a lamp in the room, about its centre
};

/// A distant light sees the casters of `triangles`, as far as they lie within `radius` of `centre` (m in world); its
/// view changes in steps, so that shadows do not shimmer while something moves. A lamp sees its cone.
[[nodiscard]] ShadowView shadow_view(const mjvScene_& scene, const SceneTriangles& triangles,
                                     const Eigen::Vector3f& centre, float radius, float spot_scale, int map_size);

/// World to clip coordinates of the scene's camera; y points down, so that rows come out from the top.
[[nodiscard]] Eigen::Matrix4f camera_view(const mjvScene_& scene, float aspect);

}  // namespace takt::sim
