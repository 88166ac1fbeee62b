#include "sim/film/render_scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "sim/film/render_marks.h"

namespace takt::sim {
namespace {

using Eigen::Matrix3f;
using Eigen::Matrix4f;
using Eigen::Vector3f;

constexpr float kEndlessFloor = 80;  // m, half side of the quad that stands for a plane without end

Vector3f vec(const float* v) { return {v[0], v[1], v[2]}; }

std::uint8_t to_byte(float v) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(v, 0.f, 1.f))); }

bool is_endless(const mjModel* model, const mjvGeom& geom) {
  return geom.type == mjGEOM_PLANE && geom.objtype == mjOBJ_GEOM && model->geom_size[3 * geom.objid] <= 0;
}

// How the unit shape becomes the geom: scale of its corners, and how far its two ends are pulled apart.
struct Fit {
  Vector3f scale;
  float stretch = 0;
};

Fit fit(const mjModel* model, const mjvGeom& geom) {
  switch (geom.type) {
    case mjGEOM_PLANE:
      if (is_endless(model, geom)) return {{kEndlessFloor, kEndlessFloor, 1}};
      return {{geom.size[0], geom.size[1], 1}};
    case mjGEOM_CAPSULE:
      return {{geom.size[0], geom.size[0], geom.size[0]}, geom.size[2]};
    case mjGEOM_SPHERE:
    case mjGEOM_ELLIPSOID:
    case mjGEOM_CYLINDER:
    case mjGEOM_BOX:
    case mjGEOM_ARROW:
    case mjGEOM_ARROW1:
      return {{geom.size[0], geom.size[1], geom.size[2]}};
    default:
      return {Vector3f::Ones()};
  }
}

// A texture counts as its mean colour: URDF meshes and the stage have none, and reading textures is what costs most on
// a CPU.
Vector3f mean_colour(const mjModel* model, int texture) {
  if (texture < 0 || texture >= model->ntex || model->tex_adr[texture] < 0) return Vector3f::Ones();
  const int channels = model->tex_nchannel[texture];
  const std::int64_t pixels = static_cast<std::int64_t>(model->tex_width[texture]) * model->tex_height[texture];
  const mjtByte* data = model->tex_data + model->tex_adr[texture];
  const std::int64_t stride = std::max<std::int64_t>(1, pixels / 4096);
  Vector3f sum = Vector3f::Zero();
  std::int64_t count = 0;
  for (std::int64_t i = 0; i < pixels; i += stride, ++count)
    for (int c = 0; c < 3; ++c) sum[c] += data[i * channels + std::min(c, channels - 1)] / 255.f;
  return sum / static_cast<float>(std::max<std::int64_t>(1, count));
}

/// @return the box around them
Eigen::AlignedBox3f append_vertices(const mjvGeom& geom, const Vector3f& origin, const Shape& shape, const Fit& size,
                                    const SceneVertex& look, std::vector<SceneVertex>& vertices) {
  Matrix3f rotation;
  for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = geom.mat[i];
  const Matrix3f position_map = rotation * size.scale.asDiagonal();
  const bool even = size.scale[0] == size.scale[1] && size.scale[1] == size.scale[2];
  const Matrix3f normal_map =
      even ? rotation : Matrix3f(rotation * size.scale.cwiseMax(1e-9f).cwiseInverse().asDiagonal());
  const Vector3f pull = size.stretch * rotation.col(2);
  const std::size_t first = vertices.size();
  vertices.resize(first + shape.vertices.size(), look);
  SceneVertex* out = vertices.data() + first;
  Eigen::AlignedBox3f box;
  for (const ShapeVertex& v : shape.vertices) {
    const Vector3f position = position_map * vec(v.p.data()) + v.sign * pull + origin;
    Eigen::Map<Vector3f>(out->position.data()) = position;
    box.extend(position);
    const Vector3f normal = normal_map * vec(v.normal.data());
    Eigen::Map<Vector3f>(out->normal.data()) = even ? normal : Vector3f(normal.normalized());
    ++out;
  }
  return box;
}

SceneGeom::Look look_of(const SceneGeom& drawn, const mjvGeom& geom, const Vector3f& origin, const Fit& size,
                        const SceneVertex& look) {
  SceneGeom::Look all{};
  auto out = all.begin();
  const auto add = [&out](float number) { *out++ = std::bit_cast<std::uint32_t>(number); };
  for (int i = 0; i < 3; ++i) add(origin[i]);
  for (const float part : geom.mat) add(part);
  for (int i = 0; i < 3; ++i) add(size.scale[i]);
  add(size.stretch);
  *out++ = std::bit_cast<std::uint32_t>(look.colour);
  *out++ = std::bit_cast<std::uint32_t>(look.material);
  const auto shape = std::bit_cast<std::uintptr_t>(drawn.shape);
  *out++ = static_cast<std::uint32_t>(shape);
  *out++ = static_cast<std::uint32_t>(shape >> 32U);
  *out++ = (drawn.casts_shadow ? 1U : 0U) | (drawn.transparent ? 2U : 0U) | (drawn.is_floor ? 4U : 0U) |
           (drawn.on_top ? 8U : 0U);
  return all;
}

Matrix4f look_along(const Vector3f& eye, const Vector3f& forward, const Vector3f& up_hint) {
  const Vector3f z = -forward.normalized();
  const Vector3f x = up_hint.cross(z).normalized();
  const Vector3f y = z.cross(x);
  Matrix4f view = Matrix4f::Identity();
  view.block<1, 3>(0, 0) = x.transpose();
  view.block<1, 3>(1, 0) = y.transpose();
  view.block<1, 3>(2, 0) = z.transpose();
  view.topRightCorner<3, 1>() = -view.topLeftCorner<3, 3>() * eye;
  return view;
}

Matrix4f frustum(float left, float right, float bottom, float top, float near, float far) {
  Matrix4f m = Matrix4f::Zero();
  m(0, 0) = 2 * near / (right - left);
  m(0, 2) = (right + left) / (right - left);
  m(1, 1) = 2 * near / (top - bottom);
  m(1, 2) = (top + bottom) / (top - bottom);
  m(2, 2) = -(far + near) / (far - near);
  m(2, 3) = -2 * far * near / (far - near);
  m(3, 2) = -1;
  return m;
}

Matrix4f box_view(float half_width, float half_height, float near, float far) {
  Matrix4f m = Matrix4f::Identity();
  m(0, 0) = 1 / half_width;
  m(1, 1) = 1 / half_height;
  m(2, 2) = -2 / (far - near);
  m(2, 3) = -(far + near) / (far - near);
  return m;
}

Vector3f any_normal_to(const Vector3f& v) {
  return std::abs(v.z()) < 0.9f * v.norm() ? Vector3f::UnitZ() : Vector3f::UnitX();
}

// Where the casters lie as a distant light sees them. Size and place move in steps: a quarter metre, whole texels.
struct Square {
  Eigen::Vector2f centre = Eigen::Vector2f::Zero();
  float half = 0;
};

Square square_of_casters(const SceneTriangles& triangles, const Matrix4f& view, float radius, int map_size) {
  constexpr float kStep = 0.25f;
  Eigen::AlignedBox2f bounds;
  const Eigen::Matrix<float, 2, 3> axes = view.topLeftCorner<2, 3>();
  const Eigen::Vector2f origin = view.topRightCorner<2, 1>();
  for (const SceneGeom& geom : triangles.geoms) {
    if (!geom.casts_shadow) continue;
    const SceneVertex* vertex = triangles.vertices.data() + geom.first_vertex;
    for (std::size_t i = 0; i < geom.shape->vertices.size(); ++i)
      bounds.extend(axes * vec(vertex[i].position.data()) + origin);
  }
  bounds = bounds.intersection(Eigen::AlignedBox2f(Eigen::Vector2f(-radius, -radius), Eigen::Vector2f(radius, radius)));
  if (bounds.isEmpty()) return {Eigen::Vector2f::Zero(), radius};
  Square square;
  square.half = std::min(radius, kStep * std::ceil((bounds.sizes().maxCoeff() / 2 + kStep) / kStep));
  const float texel = 2 * square.half / static_cast<float>(map_size);
  // Steps of a few texels leave the square larger than the casters by more than they can move within one step.
  const float place = std::max(1.0f, std::floor(0.5f * kStep / texel)) * texel;
  square.centre = (bounds.center() / place).array().round() * place;
  return square;
}

const mjvLight* shadow_caster(const mjvScene& scene) {
  for (int i = 0; i < scene.nlight; ++i)
    if (scene.lights[i].castshadow && !scene.lights[i].headlight) return &scene.lights[i];
  return nullptr;
}

/// What a lamp looks like: a cold lens, or one that burns (sim/model/world_description.h, lamp_wires). Other geoms as
/// they are.
void shine(const mjModel* model, const mjData* data, const mjvGeom& geom, Vector3f& colour, float& emission) {
  if (model->nuser_geom == 0 || geom.objtype != mjOBJ_GEOM || geom.objid < 0) return;
  const auto lamp = static_cast<int>(model->geom_user[geom.objid * model->nuser_geom]);
  if (lamp < 1 || lamp > model->nuserdata) return;
  constexpr float kCold = 0.35f, kWhite = 0.3f;  // share of the colour that an unlit lens has; what is overexposed
  const bool burns = data->userdata[lamp - 1] > 0.5;
  colour = burns ? Vector3f(colour + kWhite * (Vector3f::Ones() - colour)) : Vector3f(kCold * colour);
  if (burns) emission = 1.0f;
}

}  // namespace

void SceneTriangles::fill(const mjModel_* model, const mjData_* data, const mjvScene_& scene,
                          const ShapeLibrary& shapes) {
  vertices.clear();
  geoms.clear();
  for (int i = 0; i < scene.ngeom; ++i) {
    const mjvGeom& geom = scene.geoms[i];
    const Shape* shape = shapes.find(geom.type, geom.dataid);
    if (shape == nullptr || geom.rgba[3] <= 0.004f) continue;
    const bool endless = is_endless(model, geom);
    Vector3f colour = vec(geom.rgba);
    if (geom.texid >= 0) colour = colour.cwiseProduct(mean_colour(model, geom.texid));
    float emission = geom.emission;
    shine(model, data, geom, colour, emission);
    const SceneVertex look{{},
                           {},
                           {to_byte(colour[0]), to_byte(colour[1]), to_byte(colour[2]), to_byte(geom.rgba[3])},
                           {to_byte(geom.specular), to_byte(geom.shininess), to_byte(emission), 0}};
    geoms.push_back({.first_vertex = static_cast<std::uint32_t>(vertices.size()),
                     .shape = shape,
                     .centre = vec(geom.pos),
                     .casts_shadow = geom.castshadow != 0 && geom.type != mjGEOM_PLANE && geom.category != mjCAT_DECOR,
                     .transparent = geom.rgba[3] < 0.996f,
                     .is_floor = endless,
                     .on_top = geom.segid == kOnTopSegment,
                     .model_geom = geom.objtype == mjOBJ_GEOM ? geom.objid : -1});
    // MuJoCo puts an endless plane below the camera of the picture before; ours stays where the model has it.
    const Vector3f origin =
        endless ? Eigen::Map<const Eigen::Vector3d>(data->geom_xpos + 3 * geom.objid).cast<float>() : vec(geom.pos);
    const Fit size = fit(model, geom);
    SceneGeom& drawn = geoms.back();
    drawn.box = append_vertices(geom, origin, *shape, size, look, vertices);
    drawn.look = look_of(drawn, geom, origin, size, look);
  }
}

void append_indices(const SceneGeom& geom, std::vector<std::uint32_t>& indices) {
  for (const std::uint32_t index : geom.shape->indices) indices.push_back(geom.first_vertex + index);
}

void SceneLights::fill(const mjvScene_& scene) {
  count = 0;
  shadow_light = -1;
  all_distant = true;
  ambient.setZero();
  code.clear();
  const mjvLight* caster = shadow_caster(scene);
  for (int i = 0; i < scene.nlight && count < kMost; ++i) {
    const mjvLight& light = scene.lights[i];
    ambient += vec(light.ambient);
    if (light.type == mjLIGHT_IMAGE) continue;
    const auto slot = static_cast<std::size_t>(count);
    const bool distant = light.type == mjLIGHT_DIRECTIONAL;
    const bool shadowed = &light == caster;
    all_distant = all_distant && distant;
    if (shadowed) shadow_light = count;
    axis[slot] = vec(light.dir).normalized();
    at[slot] = distant ? Vector3f(-axis[slot]) : vec(light.pos);
    diffuse[slot] = vec(light.diffuse);
    specular[slot] = vec(light.specular);
    const bool spot = light.type == mjLIGHT_SPOT && light.cutoff < 90;
    const float cut_off = spot ? std::cos(light.cutoff * std::numbers::pi_v<float> / 180) : -2;
    fading[slot] = {light.attenuation[0], light.attenuation[1], light.attenuation[2], cut_off};
    code += fmt::format("{}({}, {});", distant ? "distant" : "near", count, shadowed ? "lit" : "1.0");
    if (specular[slot].maxCoeff() > 0.01f && distant)
      code += fmt::format("shine(light_at[{0}], {0}, {1});", count, shadowed ? "lit" : "1.0");
    ++count;
  }
}

ShadowView shadow_view(const mjvScene_& scene, const SceneTriangles& triangles, const Vector3f& centre, float radius,
                       float spot_scale, int map_size) {
  const mjvLight* light = shadow_caster(scene);
  if (light == nullptr) return {};
  const Vector3f direction = vec(light->dir).normalized();
  if (light->type == mjLIGHT_DIRECTIONAL) {
    Matrix4f view = look_along(centre - 2 * radius * direction, direction, any_normal_to(direction));
    const Square square = square_of_casters(triangles, view, radius, map_size);
    view.topRightCorner<2, 1>() -= square.centre;
    return {box_view(square.half, square.half, 0.01f, 4 * radius) * view, 2 * square.half};
  }
  const float cut_off = std::clamp(light->cutoff * spot_scale, 5.f, 80.f) * std::numbers::pi_v<float> / 180;
  const Vector3f eye = vec(light->pos);
  const float distance = (eye - centre).norm();
  const float far = distance + 2 * radius, near = 0.02f * far;
  const float half = near * std::tan(cut_off);
  return {frustum(-half, half, -half, half, near, far) * look_along(eye, direction, any_normal_to(direction)),
          2 * distance * std::tan(cut_off)};
}

Matrix4f camera_view(const mjvScene_& scene, float aspect) {
  const mjvGLCamera camera = mjv_averageCamera(&scene.camera[0], &scene.camera[1]);
  const float half_height = (camera.frustum_top - camera.frustum_bottom) / 2;
  const float half_width = half_height * aspect;
  const float centre = camera.frustum_center;
  const Matrix4f view = look_along(vec(camera.pos), vec(camera.forward), vec(camera.up));
  Matrix4f projection = camera.orthographic != 0
                            ? box_view(half_width, half_height, camera.frustum_near, camera.frustum_far)
                            : frustum(centre - half_width, centre + half_width, camera.frustum_bottom,
                                      camera.frustum_top, camera.frustum_near, camera.frustum_far);
  projection.row(1) *= -1;
  return projection * view;
}

}  // namespace takt::sim
