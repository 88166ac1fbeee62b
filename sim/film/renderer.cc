#include "sim/film/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
// After gl.h.
#include <GL/glext.h>

#include <fmt/format.h>
#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "sim/film/render_changes.h"
#include "sim/film/render_gl.h"
#include "sim/film/render_marks.h"
#include "sim/film/render_scene.h"
#include "sim/film/render_shaders.h"
#include "sim/film/render_shapes.h"
#include "sim/film/render_view.h"
#include "sim/model/mujoco_errors.h"

namespace takt::sim {
namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;

constexpr int kLargestSide = 4096;
constexpr float kHazeDistance = 5;  // in extents of the model

Diagnostics check(const RenderOptions& options) {
  Diagnostics diagnostics;
  const auto in_range = [&](const char* pointer, int value, int low, int high) {
    if (value < low || value > high)
      diagnostics.error(Code::kOutOfRange, pointer, fmt::format("{} is out of range", value),
                        fmt::format("Choose {} to {}", low, high));
  };
  in_range("/width", options.width, 16, kLargestSide);
  in_range("/height", options.height, 16, kLargestSide);
  if (options.shadow_size != 0) in_range("/shadow_size", options.shadow_size, 256, 8192);
  in_range("/max_geoms", options.max_geoms, 1, 100'000);
  return diagnostics;
}

// A uniform that a program does not use has location -1, which OpenGL ignores.
void set(GLuint program, const char* name, const Matrix4f& m) {
  glUniformMatrix4fv(glGetUniformLocation(program, name), 1, GL_FALSE, m.data());
}
void set(GLuint program, const char* name, const Vector3f& v) {
  glUniform3fv(glGetUniformLocation(program, name), 1, v.data());
}
void set(GLuint program, const char* name, float v) { glUniform1f(glGetUniformLocation(program, name), v); }

Vector3f linear(const Vector3f& colour) { return colour.cwiseProduct(colour); }

// Colours of the sky, sRGB.
struct Sky {
  Vector3f horizon{0.72f, 0.76f, 0.81f};
  Vector3f zenith{0.45f, 0.53f, 0.63f};
};

// A model with a sky texture gives the middle of its upper face for the zenith, and its haze for the horizon.
Sky sky_of(const mjModel* model) {
  for (int i = 0; i < model->ntex; ++i) {
    if (model->tex_type[i] != mjTEXTURE_SKYBOX || model->tex_adr[i] < 0 || model->tex_nchannel[i] < 3) continue;
    const std::int64_t width = model->tex_width[i];
    const std::int64_t faces = model->tex_height[i] / std::max<std::int64_t>(1, width);
    const std::int64_t row = faces >= 6 ? 2 * width + width / 2 : model->tex_height[i] / 2;
    const mjtByte* pixel = model->tex_data + model->tex_adr[i] + model->tex_nchannel[i] * (row * width + width / 2);
    return {Eigen::Map<const Vector3f>(model->vis.rgba.haze), Vector3f(pixel[0], pixel[1], pixel[2]) / 255};
  }
  return {};
}

}  // namespace

class Renderer::Impl {
 public:
  Impl(const mjModel* model, const RenderOptions& options, GlContext context)
      : model_(model), options_(options), context_(std::move(context)), shapes_(model) {
    mjv_defaultScene(&scene_);
    mjv_makeScene(model, &scene_, options.max_geoms);
    mjv_defaultOption(&visible_);
    if (!options.show_sites) std::ranges::fill(visible_.sitegroup, mjtByte{0});
    sky_ = sky_of(model);
  }

  ~Impl() {
    mjv_freeScene(&scene_);
    // The context takes its textures, buffers and programs along.
  }

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<void> start() {
    make_buffers();
    if (options_.shadow_size > 0) make_shadow_map();
    Result<unsigned> shadow = build_program("", kShadowVertexShader, "", kShadowFragmentShader);
    if (!shadow) return std::unexpected(shadow.error());
    Result<unsigned> sky = build_program("", kSkyVertexShader, "", kSkyFragmentShader);
    if (!sky) return std::unexpected(sky.error());
    shadow_program_ = *shadow;
    sky_program_ = *sky;
    (void)views_.find(0, options_.width, options_.height);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE || glGetError() != GL_NO_ERROR)
      return failure(Code::kSystem, "", "OpenGL has no memory for the picture", "Choose a smaller size or shadow map");
    return {};
  }

  Result<void> set_marks(const Marks& marks) {
    const std::vector<double>& qpos = marks.ghost.qpos;
    if (!qpos.empty() && static_cast<mjtSize>(qpos.size()) != model_->nq)
      return failure(Code::kWrongSize, "",
                     fmt::format("the ghost has {} positions, the model {}", qpos.size(), model_->nq));
    marks_ = marks;
    if (qpos.empty()) return {};
    return mujoco_call("", [&] { pose_ghost(); });
  }

  Result<void> set_state(mjData* data) {
    data_ = data;
    uploaded_ = false;
    return {};
  }

  Result<void> draw(const CameraView& camera, int width, int height, Image& image) {
    if (data_ == nullptr) return failure(Code::kNotPossibleNow, "", "no state to draw: call set_state first");
    if (width < 16 || height < 16 || width > options_.width || height > options_.height)
      return failure(Code::kOutOfRange, "", fmt::format("cannot draw {}x{} pixels", width, height),
                     fmt::format("Choose 16x16 to {}x{}", options_.width, options_.height));
    const auto* index = std::get_if<int>(&camera);
    if (index != nullptr && (*index < 0 || *index >= model_->ncam))
      return failure(Code::kUnknownName, "", fmt::format("the model has no camera {}", *index));
    if (!context_.make_current()) return failure(Code::kSystem, "", "the OSMesa context cannot be made current");

    Result<void> updated = mujoco_call("", [&] { update_scene(camera); });
    if (!updated) return updated;
    if (!uploaded_) upload();
    RenderView& drawn = views_.find(camera, width, height);
    Result<GLuint> program = program_for(false, has_shadow());
    Result<GLuint> floor_program = program_for(lights_.all_distant, has_shadow());
    if (!program) return std::unexpected(program.error());
    if (!floor_program) return std::unexpected(floor_program.error());
    drawn.find_changes(scene_, triangles_, lights_, shadow_view_, shadow_reach());
    if (!drawn.mask.empty()) draw_view(*program, *floor_program, drawn);
    read_back(width, height, image);
    if (const GLenum error = glGetError(); error != GL_NO_ERROR)
      return failure(Code::kSystem, "", fmt::format("OpenGL error 0x{:x} while drawing", error));
    if (options_.smooth_edges) smoother_.smooth(image);
    return {};
  }

  std::string implementation() {
    if (!context_.make_current()) return {};
    return reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  }

 private:
  struct Range {
    GLsizei count = 0;
    std::size_t first = 0;
  };

  void make_buffers() {
    glGenVertexArrays(1, &vertex_array_);
    glBindVertexArray(vertex_array_);
    glGenBuffers(1, &vertex_buffer_);
    glGenBuffers(1, &index_buffer_);
    glBindBuffer(GL_ARRAY_BUFFER, vertex_buffer_);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, index_buffer_);
    const auto attribute = [](GLuint slot, GLint size, GLenum type, GLboolean scaled, std::size_t offset) {
      glVertexAttribPointer(slot, size, type, scaled, sizeof(SceneVertex), reinterpret_cast<const void*>(offset));
      glEnableVertexAttribArray(slot);
    };
    attribute(0, 3, GL_FLOAT, GL_FALSE, offsetof(SceneVertex, position));
    attribute(1, 3, GL_FLOAT, GL_FALSE, offsetof(SceneVertex, normal));
    attribute(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(SceneVertex, colour));
    attribute(3, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(SceneVertex, material));
  }

  std::optional<ShadowReach> shadow_reach() const {
    if (!has_shadow()) return std::nullopt;
    constexpr float kTexels = 4;  // the filter's, the slope's, and the way that corners are pushed along their normals
    ShadowReach reach{.direction = {}, .lowest = 0, .margin = 0};
    reach.margin = kTexels * shadow_view_.width / static_cast<float>(options_.shadow_size);
    if (lights_.all_distant) reach.direction = lights_.axis[static_cast<std::size_t>(lights_.shadow_light)];
    for (const SceneGeom& geom : triangles_.geoms) reach.lowest = std::min(reach.lowest, geom.box.min().z());
    return reach;
  }

  // 16 bits over four radii are 0.2 mm for a scene of 5 m, well below the bias.
  void make_shadow_map() {
    glGenTextures(1, &shadow_map_);
    glBindTexture(GL_TEXTURE_2D, shadow_map_);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT16, options_.shadow_size, options_.shadow_size, 0,
                 GL_DEPTH_COMPONENT, GL_UNSIGNED_SHORT, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    const float lit[4] = {1, 1, 1, 1};
    glTexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, lit);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    glGenFramebuffers(1, &shadow_buffer_);
    glBindFramebuffer(GL_FRAMEBUFFER, shadow_buffer_);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, shadow_map_, 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
  }

  void update_scene(const CameraView& camera) {
    mjvCamera view;
    mjv_defaultCamera(&view);
    if (const auto* index = std::get_if<int>(&camera)) {
      view.type = mjCAMERA_FIXED;
      view.fixedcamid = *index;
    } else {
      const auto& free = std::get<FreeCamera>(camera);
      view.type = mjCAMERA_FREE;
      std::ranges::copy(free.look_at, view.lookat);
      view.distance = free.distance;
      view.azimuth = free.azimuth;
      view.elevation = free.elevation;
    }
    mjv_updateScene(model_, data_, &visible_, nullptr, &view, mjCAT_ALL, &scene_);
    if (!marks_.ghost.qpos.empty()) append_ghost(*model_, *ghost_, marks_.ghost, visible_, scene_);
    append_shapes(marks_, scene_);
    lights_.fill(scene_);
  }

  void pose_ghost() {
    if (!ghost_) ghost_.reset(mj_makeData(model_));
    std::ranges::copy(marks_.ghost.qpos, ghost_->qpos);
    pose_for_drawing(model_, ghost_.get());
  }

  bool has_shadow() const { return options_.shadow_size > 0 && lights_.shadow_light >= 0; }

  // The corners of the state, and its shadow map; every view of the state shares them.
  void upload() {
    triangles_.fill(model_, data_, scene_, shapes_);
    glBindBuffer(GL_ARRAY_BUFFER, vertex_buffer_);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(triangles_.vertices.size() * sizeof(SceneVertex)),
                 triangles_.vertices.data(), GL_STREAM_DRAW);
    if (has_shadow()) draw_shadow_map();
    uploaded_ = true;
  }

  void upload_indices() {
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices_.size() * sizeof(std::uint32_t)),
                 indices_.data(), GL_STREAM_DRAW);
  }

  static void draw_range(const Range& range) {
    if (range.count == 0) return;
    glDrawElements(GL_TRIANGLES, range.count, GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(range.first * sizeof(std::uint32_t)));
  }

  void draw_shadow_map() {
    const Vector3f centre = Eigen::Map<const Eigen::Vector3d>(model_->stat.center).cast<float>();
    const float radius = static_cast<float>(model_->stat.extent) * model_->vis.map.shadowclip;
    shadow_view_ = shadow_view(scene_, triangles_, centre, radius, model_->vis.map.shadowscale, options_.shadow_size);
    const Matrix4f& view = shadow_view_.clip_from_world;
    const auto casts = [](const SceneGeom& geom) { return geom.casts_shadow && !geom.transparent; };
    const auto changed = shadow_geoms_.replace(triangles_, casts);
    TileMask mask(options_.shadow_size, options_.shadow_size);
    if (view != shadow_map_view_) {
      mask.add_all();
    } else {
      mark(changed, view, options_.shadow_size, options_.shadow_size, std::nullopt, mask);
    }
    shadow_map_view_ = view;
    if (mask.empty()) return;
    const auto [left, top, width, height] = mask.bounds();
    TileMask rectangle(options_.shadow_size, options_.shadow_size);
    rectangle.add(PixelBox(Eigen::Vector2f(left, top), Eigen::Vector2f(left + width - 1, top + height - 1)));
    indices_.clear();
    for (const SceneGeom& geom : triangles_.geoms)
      if (casts(geom) && rectangle.meets(pixels_of(geom.box, view, options_.shadow_size, options_.shadow_size)))
        append_indices(geom, indices_);
    upload_indices();
    glBindFramebuffer(GL_FRAMEBUFFER, shadow_buffer_);
    glViewport(0, 0, options_.shadow_size, options_.shadow_size);
    glEnable(GL_SCISSOR_TEST);
    glScissor(left, top, width, height);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_LESS);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.5f, 2.0f);
    glClearDepth(1.0);
    glClear(GL_DEPTH_BUFFER_BIT);
    glUseProgram(shadow_program_);
    set(shadow_program_, "clip_from_world", view);
    draw_range({static_cast<GLsizei>(indices_.size()), 0});
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_POLYGON_OFFSET_FILL);
  }

  // Programs differ by the scene's lights; a light switched on or off by the model makes new ones.
  Result<GLuint> program_for(bool is_floor, bool shadowed) {
    const bool near_shadow = shadowed && !lights_.all_distant;
    const std::string defines =
        fmt::format("{}{}#define MAX_LIGHTS {}\n#define SHADOW_LIGHT {}\n#define LIGHTING float lit = shadow(); {}\n",
                    shadowed ? "#define SHADOWS\n" : "", near_shadow ? "#define NEAR_SHADOW\n" : "",
                    std::max(1, lights_.count), lights_.shadow_light, lights_.code);
    const std::pair key{defines, is_floor};
    if (const auto found = programs_.find(key); found != programs_.end()) return found->second;
    Result<unsigned> made = is_floor
                                ? build_program(defines, kFloorVertexShader, kShadowFunction, kFloorFragmentShader)
                                : build_program(defines, kSurfaceVertexShader, kShadowFunction, kSurfaceFragmentShader);
    if (made) programs_.emplace(key, *made);
    return made;
  }

  void set_uniforms(GLuint program, const Matrix4f& view) {
    glUseProgram(program);
    const mjvGLCamera camera = mjv_averageCamera(&scene_.camera[0], &scene_.camera[1]);
    set(program, "clip_from_world", view);
    set(program, "eye", Vector3f(camera.pos[0], camera.pos[1], camera.pos[2]));
    set(program, "ambient_up", Vector3f(1.25f * lights_.ambient));
    set(program, "ambient_down", Vector3f(0.6f * lights_.ambient));
    const Vector3f haze = linear(sky_.horizon);
    glUniform4f(glGetUniformLocation(program, "haze"), haze[0], haze[1], haze[2],
                1 / (kHazeDistance * static_cast<float>(model_->stat.extent)));
    const GLsizei count = lights_.count;
    const auto array = [&](const char* name, const auto& values) {
      glUniform3fv(glGetUniformLocation(program, name), count, values[0].data());
    };
    array("light_at", lights_.at);
    array("light_axis", lights_.axis);
    array("light_diffuse", lights_.diffuse);
    array("light_specular", lights_.specular);
    glUniform4fv(glGetUniformLocation(program, "light_fading"), count, lights_.fading[0].data());
    if (!has_shadow()) return;
    Matrix4f to_texture = Matrix4f::Identity();
    to_texture.diagonal().head<3>().setConstant(0.5f);
    to_texture.topRightCorner<3, 1>().setConstant(0.5f);
    set(program, "shadow_from_world", Matrix4f(to_texture * shadow_view_.clip_from_world));
    set(program, "shadow_offset", 1.5f * shadow_view_.width / static_cast<float>(options_.shadow_size));
    glUniform1i(glGetUniformLocation(program, "shadow_map"), 0);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, shadow_map_);
  }

  // Opaque geoms from near to far, so that hidden pixels are never lit; then floor, sky, and what one looks through.
  void draw_view(GLuint program, GLuint floor_program, const RenderView& drawn) {
    const Matrix4f& view = drawn.clip_from_world;
    const mjvGLCamera camera = mjv_averageCamera(&scene_.camera[0], &scene_.camera[1]);
    const Vector3f eye(camera.pos[0], camera.pos[1], camera.pos[2]);
    std::vector<const SceneGeom*> order;
    for (const SceneGeom& geom : triangles_.geoms) order.push_back(&geom);
    std::ranges::stable_sort(order, {}, [&](const SceneGeom* geom) { return (geom->centre - eye).squaredNorm(); });
    indices_.clear();
    const auto collect = [&](auto wanted) {
      const std::size_t first = indices_.size();
      for (const SceneGeom* geom : order)
        if (wanted(*geom) && (drawn.mask.whole() || geom->is_floor ||
                              drawn.mask.meets(pixels_of(geom->box, view, drawn.width, drawn.height))))
          append_indices(*geom, indices_);
      return Range{static_cast<GLsizei>(indices_.size() - first), first};
    };
    const auto inside = [](const SceneGeom& geom) { return !geom.is_floor && !geom.on_top; };
    const Range opaque = collect([&](const SceneGeom& geom) { return !geom.transparent && inside(geom); });
    const Range floor = collect([](const SceneGeom& geom) { return geom.is_floor; });
    std::ranges::reverse(order);
    const Range transparent = collect([&](const SceneGeom& geom) { return geom.transparent && inside(geom); });
    const Range on_top = collect([](const SceneGeom& geom) { return geom.on_top; });
    upload_indices();

    glViewport(0, 0, drawn.width, drawn.height);
    glEnable(GL_CULL_FACE);
    glFrontFace(GL_CW);  // the camera's y points down
    glEnable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_LEQUAL);
    clear_depth(drawn);
    const float aspect = static_cast<float>(drawn.width) / static_cast<float>(drawn.height);
    set_uniforms(program, view);
    draw_range(opaque);
    if (floor.count > 0) {
      set_uniforms(floor_program, view);
      draw_range(floor);
    }
    draw_sky(camera, aspect);
    if (transparent.count > 0) {
      glUseProgram(program);
      glEnable(GL_CULL_FACE);
      glEnable(GL_BLEND);
      glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
      glDepthMask(GL_FALSE);
      draw_range(transparent);
      glDepthMask(GL_TRUE);
    }
    draw_on_top(program, on_top, drawn);
    glDisable(GL_SCISSOR_TEST);
  }

  /// Where the picture stays as it is nothing can be nearer: no pixel is lit there.
  static void clear_depth(const RenderView& drawn) {
    glDisable(GL_SCISSOR_TEST);
    glClearDepth(drawn.mask.whole() ? 1.0 : 0.0);
    glClear(GL_DEPTH_BUFFER_BIT);
    if (drawn.mask.whole()) return;
    glEnable(GL_SCISSOR_TEST);
    glClearDepth(1.0);
    for (const auto& [left, top, right, bottom] : drawn.mask.rectangles()) {
      glScissor(left, top, right - left, bottom - top);
      glClear(GL_DEPTH_BUFFER_BIT);
    }
    const auto [left, top, width, height] = drawn.mask.bounds();
    glScissor(left, top, width, height);
  }

  /// With depths of their own: they hide each other, and nothing hides them.
  static void draw_on_top(GLuint program, const Range& range, const RenderView& drawn) {
    if (range.count == 0) return;
    glUseProgram(program);
    glEnable(GL_CULL_FACE);
    glDisable(GL_BLEND);
    clear_depth(drawn);
    draw_range(range);
  }

  void draw_sky(const mjvGLCamera& camera, float aspect) {
    glDisable(GL_CULL_FACE);
    glUseProgram(sky_program_);
    const Vector3f forward(camera.forward[0], camera.forward[1], camera.forward[2]);
    const Vector3f up(camera.up[0], camera.up[1], camera.up[2]);
    const float half = (camera.frustum_top - camera.frustum_bottom) / 2 / camera.frustum_near;
    set(sky_program_, "forward", forward);
    set(sky_program_, "up", Vector3f(-half * up));
    set(sky_program_, "right", Vector3f(half * aspect * forward.cross(up).normalized()));
    set(sky_program_, "horizon", linear(sky_.horizon));
    set(sky_program_, "zenith", linear(sky_.zenith));
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }

  static void read_back(int width, int height, Image& image) {
    image.resize(width, height);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
  }

  const mjModel* model_;
  RenderOptions options_;
  GlContext context_;
  ShapeLibrary shapes_;
  mjvScene scene_{};
  mjvOption visible_{};
  mjData* data_ = nullptr;
  Marks marks_;
  std::unique_ptr<mjData, decltype(&mj_deleteData)> ghost_{nullptr, &mj_deleteData};
  bool uploaded_ = false;
  EdgeSmoother smoother_;
  SceneTriangles triangles_;
  SceneLights lights_;
  std::vector<std::uint32_t> indices_;
  Sky sky_;
  ShadowView shadow_view_;
  DrawnGeoms shadow_geoms_;  ///< in the shadow map
  Matrix4f shadow_map_view_ = Matrix4f::Zero();
  RenderViews views_;
  GLuint vertex_array_ = 0, vertex_buffer_ = 0, index_buffer_ = 0;
  GLuint shadow_buffer_ = 0, shadow_map_ = 0;
  GLuint shadow_program_ = 0, sky_program_ = 0;
  std::map<std::pair<std::string, bool>, GLuint> programs_;
};

Result<int> find_camera(const mjModel_* model, std::string_view name, const std::string& pointer) {
  std::vector<std::string> names;
  for (int i = 0; i < model->ncam; ++i) {
    const char* camera = mj_id2name(model, mjOBJ_CAMERA, i);
    names.emplace_back(camera != nullptr ? camera : "");
    if (names.back() == name) return i;
  }
  return failure(Code::kUnknownName, pointer, fmt::format("there is no camera '{}'", name),
                 names.empty() ? "the model has no camera" : nearest_choice(name, names));
}

FreeCamera overview_camera(const mjModel_* model) {
  FreeCamera camera;
  std::copy_n(model->stat.center, 3, camera.look_at.begin());
  camera.distance = 1.5 * model->stat.extent;
  return camera;
}

void pose_for_drawing(const mjModel_* model, mjData_* data) {
  mj_kinematics(model, data);
  mj_comPos(model, data);
  mj_camlight(model, data);
  mj_tendon(model, data);
}

Renderer::Renderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Result<Renderer> Renderer::create(const mjModel_* model, const RenderOptions& options) {
  if (Diagnostics diagnostics = check(options); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  Result<GlContext> context = GlContext::create();
  if (!context) return std::unexpected(context.error());
  std::unique_ptr<Impl> impl;
  Result<void> made = mujoco_call("", [&] { impl = std::make_unique<Impl>(model, options, std::move(*context)); });
  if (made) made = impl->start();
  if (!made) return std::unexpected(made.error());
  return Renderer(std::move(impl));
}

Result<void> Renderer::set_marks(const Marks& marks) { return impl_->set_marks(marks); }

Result<void> Renderer::set_state(mjData_* data) { return impl_->set_state(data); }

Result<void> Renderer::draw(const CameraView& camera, int width, int height, Image& image) {
  return impl_->draw(camera, width, height, image);
}

std::string Renderer::implementation() const { return impl_->implementation(); }

}  // namespace takt::sim
