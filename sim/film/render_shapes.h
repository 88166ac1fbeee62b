#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

struct mjModel_;

namespace takt::sim {

/// Corner of a triangle of a shape in its own frame: position = scale * p + stretch * sign * z-axis. The two parts let
/// one unit capsule serve all lengths.
struct ShapeVertex {
  std::array<float, 3> p;
  float sign;  ///< -1, 0 or +1
  std::array<float, 3> normal;
};

/// Triangles with shared corners, counter-clockwise seen from outside.
struct Shape {
  std::vector<ShapeVertex> vertices;
  std::vector<std::uint32_t> indices;  ///< three per triangle
};

/// Every shape that a model's geoms can need: the built-in ones of unit size and the meshes and height fields as they
/// are. Made once per model. Thread: any, constant after construction.
class ShapeLibrary {
 public:
  explicit ShapeLibrary(const mjModel_* model);

  /// The shape of a geom of type `type` (mjtGeom) with mjvGeom's `data_id`; null for types that are not drawn.
  [[nodiscard]] const Shape* find(int type, int data_id) const;

 private:
  std::vector<Shape> built_in_;  ///< by mjtGeom; empty shapes for types without
  std::vector<Shape> meshes_;
  std::vector<Shape> height_fields_;
  Shape arrow_;
};

/// Triangles the renderer draws for the visible geoms of `model` (groups 0 to 2): faces of meshes and height fields and
/// the tessellation of the built-in shapes. Realtime: setup.
[[nodiscard]] int triangle_count(const mjModel_* model);

/// A scene with more triangles than this deserves a warning: a thousand of them cost 0.4 ms of every frame
/// (docs/film.md, "Speed").
inline constexpr int kTriangleBudget = 15'000;

}  // namespace takt::sim
