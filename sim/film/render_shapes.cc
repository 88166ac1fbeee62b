#include "sim/film/render_shapes.h"

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

// Lighting is per pixel, so only outlines show these counts.
constexpr int kSlices = 32;
constexpr int kStacks = 16;

using Vec3 = std::array<float, 3>;

std::uint32_t add(Shape& shape, const Vec3& p, float sign, const Vec3& normal) {
  shape.vertices.push_back({p, sign, normal});
  return static_cast<std::uint32_t>(shape.vertices.size() - 1);
}

void triangle(Shape& shape, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  shape.indices.insert(shape.indices.end(), {a, b, c});
}

Vec3 on_circle(int slice) {
  const double angle = 2 * std::numbers::pi * slice / kSlices;
  return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0};
}

// A surface of revolution about z through rings from the top down; `rings` gives radius, z, sign and the normal's
// parts.
struct Ring {
  double radius, z;
  float sign;
  double normal_out, normal_up;
};

void revolve(Shape& shape, const std::vector<Ring>& rings) {
  const auto first = static_cast<std::uint32_t>(shape.vertices.size());
  for (const Ring& ring : rings) {
    for (int slice = 0; slice <= kSlices; ++slice) {
      const Vec3 c = on_circle(slice);
      const auto radius = static_cast<float>(ring.radius);
      const auto out = static_cast<float>(ring.normal_out);
      add(shape, {radius * c[0], radius * c[1], static_cast<float>(ring.z)}, ring.sign,
          {out * c[0], out * c[1], static_cast<float>(ring.normal_up)});
    }
  }
  const std::uint32_t row = kSlices + 1;
  for (std::uint32_t r = 0; r + 1 < rings.size(); ++r) {
    for (std::uint32_t s = 0; s < kSlices; ++s) {
      const std::uint32_t upper = first + r * row + s;
      const std::uint32_t lower = upper + row;
      if (rings[r].radius > 0) triangle(shape, upper, lower, upper + 1);
      if (rings[r + 1].radius > 0) triangle(shape, upper + 1, lower, lower + 1);
    }
  }
}

// Half a unit sphere from the pole (or to it), moved along z by `sign`.
std::vector<Ring> dome(int from_stack, int to_stack, float sign) {
  std::vector<Ring> rings;
  for (int stack = from_stack; stack <= to_stack; ++stack) {
    const double angle = std::numbers::pi * stack / kStacks;
    const double radius = (stack == 0 || stack == kStacks) ? 0 : std::sin(angle);
    rings.push_back({radius, std::cos(angle), sign, radius, std::cos(angle)});
  }
  return rings;
}

Shape make_sphere() {
  Shape shape;
  revolve(shape, dome(0, kStacks, 0));
  return shape;
}

Shape make_capsule() {
  Shape shape;
  std::vector<Ring> rings = dome(0, kStacks / 2, 1);
  const std::vector<Ring> lower = dome(kStacks / 2, kStacks, -1);
  rings.insert(rings.end(), lower.begin(), lower.end());
  revolve(shape, rings);
  return shape;
}

Shape make_cylinder() {
  Shape shape;
  revolve(shape, {{0, 1, 0, 0, 1}, {1, 1, 0, 0, 1}});
  revolve(shape, {{1, 1, 0, 1, 0}, {1, -1, 0, 1, 0}});
  revolve(shape, {{1, -1, 0, 0, -1}, {0, -1, 0, 0, -1}});
  return shape;
}

// Along +z with length 1; the head takes the last quarter.
Shape make_arrow() {
  constexpr double kNeck = 0.75;
  Shape shape;
  revolve(shape, {{0, 1, 0, 0.9, 0.4}, {1.8, kNeck, 0, 0.9, 0.4}});
  revolve(shape, {{1.8, kNeck, 0, 0, -1}, {0, kNeck, 0, 0, -1}});
  revolve(shape, {{1, kNeck, 0, 1, 0}, {1, 0, 0, 1, 0}});
  revolve(shape, {{1, 0, 0, 0, -1}, {0, 0, 0, 0, -1}});
  return shape;
}

Shape make_plane() {
  Shape shape;
  for (const auto& [x, y] : {std::pair{-1.f, -1.f}, {1.f, -1.f}, {1.f, 1.f}, {-1.f, 1.f}})
    add(shape, {x, y, 0}, 0, {0, 0, 1});
  triangle(shape, 0, 1, 2);
  triangle(shape, 0, 2, 3);
  return shape;
}

Shape make_box() {
  Shape shape;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.f, 1.f}) {
      const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      std::array<std::uint32_t, 4> corner{};
      for (std::size_t i = 0; i < 4; ++i) {
        Vec3 p{}, n{};
        n[axis] = p[axis] = side;
        p[u] = (i == 1 || i == 2) ? 1.f : -1.f;
        p[v] = i >= 2 ? 1.f : -1.f;
        corner[i] = add(shape, p, 0, n);
      }
      const bool outward = side > 0;
      triangle(shape, corner[0], corner[outward ? 1 : 2], corner[outward ? 2 : 1]);
      triangle(shape, corner[0], corner[outward ? 2 : 3], corner[outward ? 3 : 2]);
    }
  }
  return shape;
}

// MuJoCo keeps positions and normals apart; a corner here is a pair of both.
Shape make_mesh(const mjModel* model, int mesh) {
  Shape shape;
  std::map<std::pair<int, int>, std::uint32_t> corner_of;
  const float* vertices = model->mesh_vert + 3 * model->mesh_vertadr[mesh];
  const float* normals = model->mesh_normal + 3 * model->mesh_normaladr[mesh];
  const int first = 3 * model->mesh_faceadr[mesh];
  for (int i = first; i < first + 3 * model->mesh_facenum[mesh]; ++i) {
    const std::pair key{model->mesh_face[i], model->mesh_facenormal[i]};
    auto [found, is_new] = corner_of.try_emplace(key, 0);
    if (is_new) {
      const float* p = vertices + 3 * key.first;
      const float* n = normals + 3 * key.second;
      found->second = add(shape, {p[0], p[1], p[2]}, 0, {n[0], n[1], n[2]});
    }
    shape.indices.push_back(found->second);
  }
  return shape;
}

Shape make_height_field(const mjModel* model, int field) {
  Shape shape;
  const int rows = model->hfield_nrow[field], columns = model->hfield_ncol[field];
  const float* height = model->hfield_data + model->hfield_adr[field];
  const mjtNum* size = model->hfield_size + 4 * field;
  const auto at = [&](int r, int c) {
    r = std::clamp(r, 0, rows - 1);
    c = std::clamp(c, 0, columns - 1);
    return Vec3{static_cast<float>(size[0] * (2.0 * c / (columns - 1) - 1)),
                static_cast<float>(size[1] * (2.0 * r / (rows - 1) - 1)),
                static_cast<float>(size[2] * height[r * columns + c])};
  };
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const Vec3 w = at(r, c - 1), e = at(r, c + 1), s = at(r - 1, c), n = at(r + 1, c);
      const float slope_x = (e[2] - w[2]) / (e[0] - w[0]), slope_y = (n[2] - s[2]) / (n[1] - s[1]);
      const float length = std::sqrt(slope_x * slope_x + slope_y * slope_y + 1);
      add(shape, at(r, c), 0, {-slope_x / length, -slope_y / length, 1 / length});
    }
  }
  for (int r = 0; r + 1 < rows; ++r) {
    for (int c = 0; c + 1 < columns; ++c) {
      const auto corner = static_cast<std::uint32_t>(r * columns + c);
      const auto above = corner + static_cast<std::uint32_t>(columns);
      triangle(shape, corner, corner + 1, above + 1);
      triangle(shape, corner, above + 1, above);
    }
  }
  return shape;
}

}  // namespace

ShapeLibrary::ShapeLibrary(const mjModel_* model) : built_in_(mjNGEOMTYPES), arrow_(make_arrow()) {
  built_in_[mjGEOM_PLANE] = make_plane();
  built_in_[mjGEOM_SPHERE] = built_in_[mjGEOM_ELLIPSOID] = make_sphere();
  built_in_[mjGEOM_CAPSULE] = make_capsule();
  built_in_[mjGEOM_CYLINDER] = make_cylinder();
  built_in_[mjGEOM_BOX] = make_box();
  for (int i = 0; i < model->nmesh; ++i) meshes_.push_back(make_mesh(model, i));
  for (int i = 0; i < model->nhfield; ++i) height_fields_.push_back(make_height_field(model, i));
}

const Shape* ShapeLibrary::find(int type, int data_id) const {
  const auto entry = [](const std::vector<Shape>& list, int index) {
    return index >= 0 && static_cast<std::size_t>(index) < list.size() ? &list[static_cast<std::size_t>(index)]
                                                                       : nullptr;
  };
  if (type == mjGEOM_MESH || type == mjGEOM_SDF) return entry(meshes_, data_id / 2);  // odd: the hull, not drawn by us
  if (type == mjGEOM_HFIELD) return entry(height_fields_, data_id);
  if (type == mjGEOM_ARROW || type == mjGEOM_ARROW1) return &arrow_;
  const Shape* shape = entry(built_in_, type);
  return shape != nullptr && !shape->indices.empty() ? shape : nullptr;
}

int triangle_count(const mjModel_* model) {
  const ShapeLibrary library(model);
  std::size_t triangles = 0;
  for (int i = 0; i < model->ngeom; ++i) {
    if (model->geom_group[i] > 2) continue;
    const int type = model->geom_type[i];
    const bool is_mesh = type == mjGEOM_MESH || type == mjGEOM_SDF;
    const Shape* shape = library.find(type, is_mesh ? 2 * model->geom_dataid[i] : model->geom_dataid[i]);
    if (shape != nullptr) triangles += shape->indices.size() / 3;
  }
  return static_cast<int>(triangles);
}

}  // namespace takt::sim
