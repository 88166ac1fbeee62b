#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/film/camera_view.h"
#include "sim/film/render_changes.h"

struct mjvScene_;

namespace takt::sim {

/// What a camera has seen last, in a framebuffer of its own, and what has to be drawn anew there. The context must be
/// current. Realtime: setup.
struct RenderView {
  RenderView(const CameraView& seen_by, int picture_width, int picture_height)
      : camera(seen_by), width(picture_width), height(picture_height), mask(picture_width, picture_height) {}

  /// Compares the scene with the last one, and fills the mask. @param reach  nothing: there are no shadows
  void find_changes(const mjvScene_& scene, const SceneTriangles& triangles, const SceneLights& lights,
                    const ShadowView& shadow, const std::optional<ShadowReach>& reach);

  CameraView camera;
  int width, height;  ///< pixels
  TileMask mask;
  unsigned frame_buffer = 0;
  std::array<unsigned, 2> storage{};  ///< colour and depth
  std::int64_t last_use = 0;
  Eigen::Matrix4f clip_from_world = Eigen::Matrix4f::Zero();

 private:
  DrawnGeoms geoms_;
  std::vector<float> conditions_;  ///< what pixels depend on beside the geoms; empty: nothing has been drawn
  std::string lighting_;
};

/// The views of a renderer, a few of them.
class RenderViews {
 public:
  /// That of a camera; a new one, in place of the one that was not used for longest, if there is none. It is bound.
  RenderView& find(const CameraView& camera, int width, int height);

 private:
  std::vector<RenderView> views_;
  std::int64_t uses_ = 0;
};

}  // namespace takt::sim
