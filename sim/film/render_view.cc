#include "sim/film/render_view.h"

#include <algorithm>
#include <span>
#include <utility>

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
// After gl.h.
#include <GL/glext.h>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

constexpr std::size_t kMostViews = 4;  // of one film: a camera, an inset, the overview of a panel

std::vector<float> conditions_of(const mjvScene& scene, const SceneLights& lights, const ShadowView& shadow,
                                 const Eigen::Matrix4f& clip_from_world) {
  std::vector<float> all;
  const auto add = [&all](const auto& numbers) { all.insert(all.end(), numbers.begin(), numbers.end()); };
  const mjvGLCamera camera = mjv_averageCamera(&scene.camera[0], &scene.camera[1]);
  add(clip_from_world.reshaped());
  add(std::span(camera.pos));
  add(std::span(camera.forward));
  add(std::span(camera.up));
  add(shadow.clip_from_world.reshaped());
  all.push_back(shadow.width);
  add(lights.ambient);
  for (std::size_t i = 0; i < static_cast<std::size_t>(lights.count); ++i) {
    add(lights.at.at(i));
    add(lights.axis.at(i));
    add(lights.diffuse.at(i));
    add(lights.specular.at(i));
    add(lights.fading.at(i));
  }
  return all;
}

}  // namespace

void RenderView::find_changes(const mjvScene& scene, const SceneTriangles& triangles, const SceneLights& lights,
                              const ShadowView& shadow, const std::optional<ShadowReach>& reach) {
  clip_from_world = camera_view(scene, static_cast<float>(width) / static_cast<float>(height));
  std::vector<float> conditions = conditions_of(scene, lights, shadow, clip_from_world);
  const auto changed = geoms_.replace(triangles, [](const SceneGeom&) { return true; });
  mask.clear();
  if (conditions != conditions_ || lights.code != lighting_) {
    mask.add_all();
  } else {
    mark(changed, clip_from_world, width, height, reach, mask);
  }
  conditions_ = std::move(conditions);
  lighting_ = lights.code;
}

RenderView& RenderViews::find(const CameraView& camera, int width, int height) {
  const auto found = std::ranges::find_if(views_, [&](const RenderView& one) {
    return one.camera == camera && one.width == width && one.height == height;
  });
  if (found != views_.end()) {
    glBindFramebuffer(GL_FRAMEBUFFER, found->frame_buffer);
    found->last_use = ++uses_;
    return *found;
  }
  if (views_.size() == kMostViews) {
    const auto oldest = std::ranges::min_element(views_, {}, &RenderView::last_use);
    glDeleteFramebuffers(1, &oldest->frame_buffer);
    glDeleteRenderbuffers(2, oldest->storage.data());
    views_.erase(oldest);
  }
  RenderView& view = views_.emplace_back(camera, width, height);
  view.last_use = ++uses_;
  glGenFramebuffers(1, &view.frame_buffer);
  glBindFramebuffer(GL_FRAMEBUFFER, view.frame_buffer);
  glGenRenderbuffers(2, view.storage.data());
  const auto add_storage = [&](unsigned storage, GLenum format, GLenum attachment) {
    glBindRenderbuffer(GL_RENDERBUFFER, storage);
    glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, storage);
  };
  add_storage(view.storage[0], GL_RGBA8, GL_COLOR_ATTACHMENT0);
  add_storage(view.storage[1], GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
  return view;
}

}  // namespace takt::sim
